// Counts the cases that the test suites left in results folders (see deploy/lib/tests.sh), names every failure and every
// skip with its reason, and ends with the line `N passed, N failed, N skipped`. Exits 1 when a case failed or none ran.
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { basename, join } from 'node:path';

const cases = []; // { status: 'passed' | 'failed' | 'skipped', name, reason }
// A skip without a reason is a failure.
const add = (one) => cases.push(one.status === 'skipped' && !one.reason ? { ...one, status: 'failed', reason: 'skipped without a reason' } : one);

const entities = { lt: '<', gt: '>', amp: '&', quot: '"', apos: "'" };
const unescape = (text) =>
  text.replace(/&(#x?[0-9a-fA-F]+|\w+);/g, (whole, name) =>
    name[0] !== '#' ? (entities[name] ?? whole)
    : String.fromCodePoint(name[1] === 'x' ? parseInt(name.slice(2), 16) : Number(name.slice(1))));
const attribute = (tag, name) => {
  const found = new RegExp(`\\s${name}="([^"]*)"`).exec(tag);
  return found ? unescape(found[1]) : undefined;
};

// The elements <testcase …/> or <testcase …>…</testcase> of a JUnit-like file, as [opening tag, body].
function* testcases(text) {
  // What a test printed or said may look like markup; it is not needed here.
  const xml = text.replace(/<!\[CDATA\[[\s\S]*?\]\]>/g, '');
  const opening = /<testcase\b(?:[^>"]|"[^"]*")*>/g;
  for (let match; (match = opening.exec(xml)); ) {
    if (match[0].endsWith('/>')) { yield [match[0], '']; continue; }
    const end = xml.indexOf('</testcase>', opening.lastIndex);
    yield [match[0], xml.slice(opening.lastIndex, end < 0 ? xml.length : end)];
  }
}

const skipMessage = (body) => attribute(/<skipped\b(?:[^>"]|"[^"]*")*>/.exec(body)?.[0] ?? '', 'message') ?? '';
// A GoogleTest skip carries "file:line", a line break, and what the test said.
const skipReason = (body) => skipMessage(body).split('\n').slice(1).join(' ').trim();

// Any other program says why in a line of its output: "skipped: reason".
const printedReason = (body) => /^skipped: (.+)$/m.exec(unescape(/<system-out>([\s\S]*?)<\/system-out>/.exec(body)?.[1] ?? ''))?.[1];

function readCase(tag, body, name) {
  if (attribute(tag, 'status') === 'notrun') return { status: 'skipped', name, reason: 'disabled in its source' };
  if (attribute(tag, 'result') === 'skipped' || body.includes('<skipped')) {
    return { status: 'skipped', name, reason: skipReason(body) };
  }
  return { status: body.includes('<failure') ? 'failed' : 'passed', name, reason: '' };
}

// GoogleTest never overwrites a report: of a program that another test runs or lists, a second one (NAME_1.xml) lies beside it. Each case counts
// once, by the worst that any report says of it. Gives the failed ones, nothing when none ran.
const worst = ['passed', 'skipped', 'failed'];
function countGoogleTest(files, prefix) {
  const found = [];
  for (const file of files) {
    const seen = new Map(); // a repeated name is another case of the same report
    for (const [tag, body] of testcases(readFileSync(file, 'utf8'))) {
      // A list of cases (--gtest_list_tests) is no run.
      if (attribute(tag, 'line') !== undefined && attribute(tag, 'status') === undefined) continue;
      const name = `${prefix}${attribute(tag, 'classname')}.${attribute(tag, 'name')}`;
      const nth = seen.get(name) ?? 0;
      seen.set(name, nth + 1);
      const one = readCase(tag, body, name);
      const before = found.find((other) => other.one.name === name && other.nth === nth);
      if (before === undefined) found.push({ one, nth });
      else if (worst.indexOf(one.status) > worst.indexOf(before.one.status)) before.one = one;
    }
  }
  for (const { one } of found) add(one);
  return found.length === 0 ? undefined : found.filter(({ one }) => one.status === 'failed').length;
}

function countCtest(folder, prefix) {
  const names = readdirSync(join(folder, 'gtest')).map((file) => basename(file, '.xml'));
  const programs = new Map();
  const programOf = (name) => {
    const first = name.replace(/_\d+$/, '');
    return names.includes(first) ? first : name;
  };
  for (const name of names) {
    const program = programOf(name);
    programs.set(program, [...(programs.get(program) ?? []), join(folder, 'gtest', `${name}.xml`)]);
  }
  const failures = new Map();
  for (const [program, files] of programs) {
    const failed = countGoogleTest(files, `${prefix}${program}: `);
    if (failed !== undefined) failures.set(program, failed);
  }
  const junit = join(folder, 'ctest.xml');
  if (!existsSync(junit)) return;
  for (const [tag, body] of testcases(readFileSync(junit, 'utf8'))) {
    const test = attribute(tag, 'name');
    const program = programOf(test);
    const status = attribute(tag, 'status');
    const failed = status === 'fail' || body.includes('<failure');
    // Of a program run in parts (tests/support/part.sh) each leaves a report of its own.
    const reported = failures.has(program) && names.includes(test);
    const tell = (status, reason) => add({ status, name: `${prefix}${test}`, reason });
    if (failed && !reported) tell('failed', 'ended without a report: it crashed, hung or could not start');
    else if (failed && failures.get(program) === 0) tell('failed', 'every case passed, but the program ended badly');
    else if (!reported && (status === 'disabled' || skipMessage(body).startsWith('SKIP_')))
      tell('skipped', printedReason(body) ?? (status === 'disabled' ? 'disabled in its CMake list' : ''));
    // Neither run nor skipped: its program was not built, or a dependency failed.
    else if (!reported && status === 'notrun') tell('failed', skipMessage(body) || 'could not be run');
    else if (!reported) tell('passed', '');
  }
}

function countVitest(file) {
  for (const suite of JSON.parse(readFileSync(file, 'utf8')).testResults) {
    const where = suite.name.split('/web/').pop();
    // It could not be loaded, or a hook failed: the cases behind it are reported as skipped.
    if (suite.status === 'failed' && !suite.assertionResults.some((one) => one.status === 'failed'))
      add({ status: 'failed', name: `web: ${where}`, reason: suite.message || 'failed outside its cases' });
    for (const one of suite.assertionResults) {
      const status = one.status === 'passed' || one.status === 'failed' ? one.status : 'skipped';
      add({ status, name: `web: ${where}: ${one.fullName}`, reason: status === 'skipped' ? `marked ${one.status} in its source` : '' });
    }
  }
}

function countBrowser(file) {
  for (const one of JSON.parse(readFileSync(file, 'utf8')).tests)
    add({ status: one.status, name: `e2e: ${one.name}`, reason: one.reason ?? '' });
}

for (const folder of process.argv.slice(2)) {
  const prefix = { sanitize: 'sanitized ', thread: 'threads ' }[basename(folder)] ?? '';
  countCtest(folder, prefix);
  const read = (name, count) => existsSync(join(folder, name)) && count(join(folder, name));
  read('vitest.json', countVitest);
  read('e2e.json', countBrowser);
  for (const line of readFileSync(join(folder, 'steps.tsv'), 'utf8').split('\n').filter(Boolean)) {
    const [status, name, reason] = line.split('\t');
    add({ status, name, reason: reason ?? '' });
  }
}

const of = (status) => cases.filter((one) => one.status === status);
const list = (title, some) => {
  if (some.length === 0) return;
  console.log(`\n${title}`);
  for (const { name, reason } of some) console.log(`  ${name}${reason ? `: ${reason}` : ''}`);
};
list('Skipped:', of('skipped'));
list('Failed:', of('failed'));
console.log(`\n${of('passed').length} passed, ${of('failed').length} failed, ${of('skipped').length} skipped`);
process.exitCode = of('failed').length > 0 || of('passed').length === 0 ? 1 : 0;
