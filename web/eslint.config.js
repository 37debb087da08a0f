// Type-checked rules for the console, and who may use what. `npm run lint`; part of `deploy/dev check`.
import js from '@eslint/js';
import tseslint from 'typescript-eslint';

/** Only link/ writes what the console knows; everything else reads `store`. */
const writer = { group: ['**/link/store'], importNames: ['writable'], message: 'Only link/ writes the store.' };
const above = (...folders) => ({
  group: folders.map((folder) => `**/${folder}/**`),
  message: 'This layer does not know the one above it (web/README.md).',
});
const limits = (files, ...patterns) => ({ files, rules: { 'no-restricted-imports': ['error', { patterns }] } });

export default tseslint.config(
  { ignores: ['dist/', 'src/contract/'] },
  js.configs.recommended,
  ...tseslint.configs.recommendedTypeChecked,
  { languageOptions: { parserOptions: { project: './tsconfig.json', tsconfigRootDir: import.meta.dirname } } },
  {
    rules: {
      eqeqeq: ['error', 'always', { null: 'ignore' }],
      'no-console': 'error',
      // A table row or a place in an array that is known to be there says so with "!".
      '@typescript-eslint/no-non-null-assertion': 'off',
      '@typescript-eslint/no-unused-vars': ['error', { varsIgnorePattern: '^_', argsIgnorePattern: '^_', ignoreRestSiblings: true }],
      '@typescript-eslint/switch-exhaustiveness-check': ['error', { considerDefaultExhaustiveForUnions: true }],
    },
  },
  limits(['src/*.{ts,tsx}'], writer),
  limits(['src/link/**'], above('text', 'ui', 'panels')),
  limits(['src/text/**'], writer, above('ui', 'panels')),
  limits(['src/ui/**'], writer, above('panels')),
  limits(['src/panels/*/**'], writer, {
    regex: '^\\.\\./(?!\\.\\.|panel$)',
    message: 'A screen does not know another screen: what both need belongs to ui/.',
  }),
  // Tests put their own function in place of a browser's method.
  { files: ['test/**'], rules: { '@typescript-eslint/unbound-method': 'off' } },
  // Plain JavaScript of the builder and of the stand-in server: without types.
  { files: ['**/*.{js,mjs}', 'vite.config.ts'], ...tseslint.configs.disableTypeChecked },
  {
    files: ['**/*.{js,mjs}'],
    languageOptions: {
      globals: {
        console: 'readonly',
        process: 'readonly',
        Buffer: 'readonly',
        URL: 'readonly',
        document: 'readonly',
        setInterval: 'readonly',
        clearInterval: 'readonly',
        performance: 'readonly',
        setTimeout: 'readonly',
        clearTimeout: 'readonly',
        window: 'readonly',
      },
    },
    rules: { 'no-console': 'off' },
  },
);
