// Tests of words look them up without a page, which would have loaded its language by then.
import { loadLanguage } from '../src/text/text';

await Promise.all([loadLanguage('en'), loadLanguage('de')]);
