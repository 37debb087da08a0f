import { build } from 'vite';
import { defineConfig } from 'vitest/config';

// Columns of the tables that no screen shows: more than a kilobyte of the page.
const unshown: readonly (readonly [file: string, column: RegExp])[] = [
  ['/contract/params.gen.ts', / (scope|source): '(?:[^'\\]|\\.)*',/g],
  ['/contract/emergencies.gen.ts', / name: '\w+',/g],
];
const withoutUnshown = {
  name: 'without-unshown-columns',
  apply: 'build' as const,
  enforce: 'pre' as const,
  transform(code: string, id: string) {
    const row = unshown.find(([file]) => id.endsWith(file));
    return row === undefined ? null : code.replace(row[1], '');
  },
};

const pieces = { target: 'es2022', assetsInlineLimit: 0, modulePreload: { polyfill: false }, chunkSizeWarningLimit: 200 };

// The page of the API's routes is a build of its own: with a second entry the console's first load would fall into more files.
let folder = 'dist';
const docsPage = {
  name: 'docs-page',
  apply: 'build' as const,
  configResolved(config: { build: { outDir: string } }) {
    folder = config.build.outDir;
  },
  async closeBundle() {
    const own = { ...pieces, outDir: folder, emptyOutDir: false, copyPublicDir: false, rolldownOptions: { input: 'docs.html' } };
    await build({ configFile: false, logLevel: 'silent', build: own });
  },
};

// The server sends `Content-Security-Policy: default-src 'self'`: nothing may be inlined, neither scripts nor data: images.
export default defineConfig({
  plugins: [withoutUnshown, docsPage],
  oxc: { jsx: { runtime: 'automatic', importSource: 'preact' } },
  build: pieces,
  server: { host: '127.0.0.1', proxy: { '/api': 'http://127.0.0.1:8080', '/ws': { target: 'ws://127.0.0.1:8080', ws: true } } },
  // A busy machine is no failure.
  test: {
    include: ['test/**/*.test.ts'],
    setupFiles: ['test/setup.ts'],
    globalSetup: ['test-support/build.ts'],
    environment: 'node',
    testTimeout: 60_000,
    // They wait for pages more than they compute; usual is one less than there are processors.
    maxWorkers: '100%',
  },
});
