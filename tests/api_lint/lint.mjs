// The OpenAPI description, read by two third-party linters: lint.mjs OPENAPI. No error may be left; warnings are
// counted. Exits with 77 when they are not installed (npm ci in this folder).
import { spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const file = process.argv[2];
const here = dirname(fileURLToPath(import.meta.url));
const program = (name) => join(here, 'node_modules', '.bin', name);
if (!existsSync(program('redocly')) || !existsSync(program('spectral'))) {
  console.log('skipped: redocly and spectral are not installed in tests/api_lint (npm ci)');
  process.exit(77);
}
const scratch = mkdtempSync(join(tmpdir(), 'hoist-api-lint-'));
let failed = 0;
// Telemetry off: nothing is sent.
const env = { ...process.env, REDOCLY_TELEMETRY: 'off', REDOCLY_SUPPRESS_UPDATE_NOTICE: 'true' };

/** `errors` and `warnings` of what a linter printed. */
function lint(name, args, count) {
  const done = spawnSync(program(name), args, { encoding: 'utf8', env, cwd: scratch, maxBuffer: 1e8 });
  let found;
  try {
    found = count(JSON.parse(done.stdout));
  } catch (error) {
    found = { errors: [`${name} gave no report: ${error.message}\n${done.stdout}${done.stderr}`], warnings: 0 };
  }
  console.log(`${name}: ${found.errors.length} errors, ${found.warnings} warnings`);
  for (const error of found.errors) console.log(`  ${error}`);
  failed += found.errors.length;
}

writeFileSync(join(scratch, 'redocly.yaml'), 'extends:\n  - recommended\n');
lint('redocly', ['lint', '--config', 'redocly.yaml', '--format', 'json', '--max-problems', '1000', file], ({ totals, problems }) => ({
  errors: problems.filter(({ severity }) => severity === 'error').map(({ message, location }) => `${message} ${location?.[0]?.pointer ?? ''}`),
  warnings: totals.warnings,
}));
writeFileSync(join(scratch, 'spectral.yaml'), 'extends: ["spectral:oas"]\n');
lint('spectral', ['lint', '--ruleset', 'spectral.yaml', '--format', 'json', '--quiet', file], (problems) => ({
  errors: problems.filter(({ severity }) => severity === 0).map(({ message, path }) => `${message} ${path.join('.')}`),
  warnings: problems.filter(({ severity }) => severity === 1).length,
}));
rmSync(scratch, { recursive: true });
process.exit(failed === 0 ? 0 : 1);
