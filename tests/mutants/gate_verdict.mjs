// gate_verdict.mjs LIST PROGRAM EQUIVALENT: runs the gate's tests with each mutant of the list, compares the surviving ones with the list
// of equivalent ones (a line each: mutant, source line, reason, separated by tabs), and fails on any other survivor.
import { spawn } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { cpus } from 'node:os';

const [listPath, program, equivalentPath] = process.argv.slice(2);
const lines = (path) => (existsSync(path) ? readFileSync(path, 'utf8').split('\n').filter(Boolean) : []);
const mutants = lines(listPath).map((row) => row.split('\t'));
const header = readFileSync('control/core/output/safety_gate.hpp', 'utf8').split('\n');
// Compared by line content, since line numbers change.
const name = (what) => `${what.replace(/^line \d+: /, '')}\t${(header[Number(/^line (\d+)/.exec(what)[1]) - 1] ?? '').trim()}`;
const reasons = new Map(lines(equivalentPath).filter((row) => !row.startsWith('#')).map((row) => {
  const [what, source, why] = row.split('\t');
  return [`${what}\t${source}`, why];
}));

// A mutant is noticed when a test fails, which GoogleTest reports with 1. One that makes a test hang or ends the
// program counts as a survivor and needs a row with its reason.
const run = (env, limit_ms) => new Promise((done) => {
  const child = spawn(program, ['--gtest_brief=1', '--gtest_fail_fast'], { env: { ...process.env, ...env }, stdio: 'ignore', timeout: limit_ms });
  child.on('exit', (code, signal) => done(signal ?? code));
});
const begin = Date.now();
if ((await run({}, 600000)) !== 0) throw new Error('the tests fail without a mutant');
// Several times what they need without one, on this machine as busy as it is now.
const limit_ms = 20000 + 10 * (Date.now() - begin);
const notices = async (number) => {
  const end = await run({ GATE_MUTANT: number }, limit_ms);
  if (end !== 0 && end !== 1) console.log(`mutant ${number} ended with ${end}`);
  return end === 1;
};
const survived = [];
let at = 0;
const worker = async () => {
  while (at < mutants.length) {
    const [number, what] = mutants[at++];
    if (!(await notices(number))) survived.push(what);
  }
};
await Promise.all(cpus().map(worker));
const known = survived.filter((what) => reasons.has(name(what)));
const open = survived.filter((what) => !reasons.has(name(what)));
for (const what of known) console.log(`cannot be noticed: ${what}: ${reasons.get(name(what))}`);
for (const what of open) console.log(`NOT NOTICED: ${what.replace(/: /, '\t').split('\t')[0]}\t${name(what)}`);
console.log(`${mutants.length} mutants of the gate: ${mutants.length - survived.length} noticed, ${known.length} that cannot be, ${open.length} not noticed`);
process.exit(open.length > 0 ? 1 : 0);
