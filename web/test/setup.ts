// Loads the language for tests without a page.
import { loadLanguage } from '../src/text/text';

await Promise.all([loadLanguage('en'), loadLanguage('de')]);
