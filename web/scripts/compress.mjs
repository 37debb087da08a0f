// Writes NAME.gz beside every text file of dist/ that gains from it, so that the server need not compress anything.
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';

const folder = new URL('../dist', import.meta.url).pathname;
const smallest = 1024; // below that a response fits one packet anyway
for (const entry of readdirSync(folder, { recursive: true, withFileTypes: true })) {
  if (!entry.isFile() || !/\.(html|js|css|svg|json|webmanifest)$/.test(entry.name)) continue;
  const file = join(entry.parentPath, entry.name);
  const plain = readFileSync(file);
  const small = gzipSync(plain, { level: 9 });
  if (plain.length >= smallest && small.length < plain.length * 0.9) writeFileSync(`${file}.gz`, small);
}
