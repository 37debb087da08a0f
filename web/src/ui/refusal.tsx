// Why something was not done, and what to do: all reasons, in words.
import type { Reply } from '../link/socket';
import { refusalText, t } from '../text/text';

export function reasons(reply: Reply): string[] {
  const texts = reply.refusals.map(refusalText);
  for (const error of reply.errors) if (error.message && texts.length === 0) texts.push(error.message);
  return texts.length > 0 ? [...new Set(texts)] : [reply.detail && reply.detail !== '' ? reply.detail : t('refused.unknown')];
}

export function Refusal({ reply, onClose }: { reply: Reply | null; onClose: () => void }) {
  if (reply === null || reply.ok) return null;
  return (
    <div class="refusal" role="alert">
      <div>
        <strong>{t('refused.title')}</strong>
        <ul>
          {reasons(reply).map((text) => (
            <li key={text}>{text}</li>
          ))}
        </ul>
      </div>
      <button type="button" class="quiet" onClick={onClose}>
        {t('common.close')}
      </button>
    </div>
  );
}
