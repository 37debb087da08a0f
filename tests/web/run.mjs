// What `deploy/dev test` and `deploy/dev e2e` start: the two parts of e2e.mjs beside each other, each with programs and browser of its own, because
// they wait more than they compute. Options are those of e2e.mjs; one report, in which a case of both parts counts once.
import { spawn } from 'node:child_process';
import { existsSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const given = process.argv.slice(2);
const at = given.indexOf('--json');
const [, report] = at < 0 ? [] : given.splice(at, 2);
const program = fileURLToPath(new URL('e2e.mjs', import.meta.url));
const worst = ['passed', 'skipped', 'failed'];

const started = [1, 2].map((part) => {
  const json = report && `${report}.part${part}`;
  if (json) rmSync(json, { force: true }); // an earlier run's would hide that this part ended badly
  const child = spawn(process.execPath, [program, ...given, '--part', String(part), ...(json ? ['--json', json] : [])], { stdio: 'inherit' });
  return { json, child, code: new Promise((resolve) => child.on('exit', (code) => resolve(code ?? 1))) };
});
for (const signal of ['SIGINT', 'SIGTERM']) process.once(signal, () => started.forEach(({ child }) => child.kill(signal)));
const codes = await Promise.all(started.map(({ code }) => code));

// A part without a report ended badly: then there is none, which fails the suite.
if (report && started.every(({ json }) => existsSync(json))) {
  const tests = [];
  for (const { json } of started) {
    for (const one of JSON.parse(readFileSync(json, 'utf8')).tests) {
      const before = tests.findIndex(({ name }) => name === one.name);
      if (before < 0) tests.push(one);
      else if (worst.indexOf(one.status) > worst.indexOf(tests[before].status)) tests[before] = one;
    }
    rmSync(json);
  }
  writeFileSync(report, JSON.stringify({ tests }));
}
process.exit(codes.some((code) => code !== 0) ? 1 : 0);
