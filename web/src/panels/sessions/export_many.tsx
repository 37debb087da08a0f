// Many sessions as one file: chosen by day and patient, made by a job, then downloaded.
import { useState } from 'preact/hooks';
import type { Job } from '../../contract/rest.gen';
import { useJob } from '../../link/jobs';
import { address } from '../../link/rest';
import { useSettings } from '../../text/settings';
import { t } from '../../text/text';
import { Form, Trouble } from '../../ui/field';
import { Progress } from '../../ui/progress';
import { SessionChoiceFields, useSessionChoice } from '../../ui/session_choice';

const mega = 1e6;
/** What the file holds; both kinds of reports are one layout. */
const contents = {
  files: 'exports.files',
  bids: 'exports.bids',
  sqlite: 'exports.sqlite',
  patient: 'exports.patient',
  full: 'exports.full',
} as const;
type Content = keyof typeof contents;

export function ExportMany() {
  const sessions = useSessionChoice();
  const [content, setContent] = useState<Content>('files');
  const { language } = useSettings();
  const [made, setMade] = useState<Job | null>(null);
  const work = useJob('export_sessions', setMade);
  const start = () => {
    setMade(null);
    void work.start({
      kind: 'export_sessions',
      ...(content === 'patient' || content === 'full' ? { layout: 'reports', report: content, language } : { layout: content }),
      ...sessions.asked,
    });
  };
  const file = made?.result?.kind === 'export_sessions' ? made.result : null;
  return (
    <>
      <h2>{t('exports.many')}</h2>
      <Form label={t('exports.many')} onSend={start}>
        <SessionChoiceFields of={sessions} disabled={work.busy}>
          <label class="field">
            <span>{t('exports.layout')}</span>
            <select value={content} disabled={work.busy} onChange={(event) => setContent(event.currentTarget.value as Content)}>
              {Object.entries(contents).map(([name, text]) => (
                <option key={name} value={name}>
                  {t(text)}
                </option>
              ))}
            </select>
          </label>
        </SessionChoiceFields>
        <button type="submit" class="plain primary" disabled={work.busy}>
          {t('exports.make')}
        </button>
      </Form>
      <Progress work={work} label={t('exports.making')} />
      <Trouble problem={work.problem} />
      {file !== null && made !== null ? (
        <p role="status">
          {t(file.sessions === 1 ? 'exports.madeOne' : 'exports.made', { n: file.sessions, mb: Math.max(1, Math.round(file.bytes / mega)) })}{' '}
          <a class="plain" href={address('GET /api/v1/jobs/{id}/file', { path: { id: made.id } })} download>
            {t('sessions.export')}
          </a>
        </p>
      ) : null}
    </>
  );
}
