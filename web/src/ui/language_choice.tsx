// The language of this device.
import { notify } from '../link/console';
import { languages, useSettings, type Language } from '../text/settings';
import { chooseLanguage, t } from '../text/text';

export function LanguageChoice() {
  const { language } = useSettings();
  const choose = async (wanted: Language) => {
    if (!(await chooseLanguage(wanted))) notify('warning', 'common.languageLost');
  };
  return (
    <div class="choice" role="radiogroup" aria-label={t('bar.language')}>
      {languages.map((item) => (
        <button key={item.id} type="button" role="radio" aria-checked={item.id === language} lang={item.id} onClick={() => void choose(item.id)}>
          {item.name}
        </button>
      ))}
    </div>
  );
}
