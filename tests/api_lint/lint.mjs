// The OpenAPI description, read by two third-party linters: lint.mjs OPENAPI. No error and no warning may be left, but for the rules switched
// off below. Exits with 77 when the linters are not installed (npm ci in this folder).
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

// A socket's upgrade answers 101 and never 2xx; its messages are components that no path names; the answer of the description's own route is
// open; the rest is ornament for a published page.
const off = {
  redocly: ['operation-2xx-response', 'no-unused-components', 'no-required-schema-properties-undefined', 'info-license'],
  spectral: ['operation-success-response', 'oas3-unused-component', 'operation-description', 'operation-tags', 'info-contact'],
};
const rules = (name) => `rules:\n${off[name].map((rule) => `  ${rule}: off\n`).join('')}`;

/** Prints and counts the errors and warnings that a linter reports. */
function lint(name, args, list) {
  const done = spawnSync(program(name), args, { encoding: 'utf8', env, cwd: scratch, maxBuffer: 1e8 });
  let found;
  try {
    found = list(JSON.parse(done.stdout));
  } catch (error) {
    found = [`${name} gave no report: ${error.message}\n${done.stdout}${done.stderr}`];
  }
  console.log(`${name}: ${found.length} errors and warnings`);
  for (const one of found) console.log(`  ${one}`);
  failed += found.length;
}

writeFileSync(join(scratch, 'redocly.yaml'), `extends:\n  - recommended\n${rules('redocly')}`);
lint('redocly', ['lint', '--config', 'redocly.yaml', '--format', 'json', '--max-problems', '1000', file], ({ problems }) =>
  problems.map(({ ruleId, message, location }) => `${ruleId}: ${message} ${location?.[0]?.pointer ?? ''}`),
);
writeFileSync(join(scratch, 'spectral.yaml'), `extends: ["spectral:oas"]\n${rules('spectral')}`);
lint('spectral', ['lint', '--ruleset', 'spectral.yaml', '--format', 'json', '--quiet', file], (problems) =>
  problems.filter(({ severity }) => severity <= 1).map(({ code, message, path }) => `${code}: ${message} ${path.join('.')}`),
);
rmSync(scratch, { recursive: true });
process.exit(failed === 0 ? 0 : 1);
