// The paper's protocol walked by virtual subjects: start it, follow it, and read each study that was made.
import { useEffect, useRef, useState } from 'preact/hooks';
import { useJob } from '../../link/jobs';
import { useQuery } from '../../link/query';
import { rest, wholeList } from '../../link/rest';
import { useStore } from '../../link/store';
import { addressOf, go } from '../../router';
import { useSettings } from '../../text/settings';
import { date, t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { Progress } from '../../ui/progress';
import { SessionChoiceFields, useSessionChoice } from '../../ui/session_choice';
import type { PanelProps } from '../panel';
import { StudyReportView } from './report';
import { paperSubjects, readWhole, seedMost, subjectsMost } from './model';
import './study.css';

export function StudyView({ part }: PanelProps) {
  useSettings();
  const role = useStore((s) => s.role);
  const [version, setVersion] = useState(0);
  const list = useQuery(() => wholeList((query) => rest('GET /api/v1/studies', { query })), [version]);
  const items = list.value?.items ?? [];
  const chosen = part !== null && /^\d+$/.test(part) ? Number(part) : (items[0]?.id ?? null);
  const again = () => setVersion((before) => before + 1);
  return (
    <div class="study">
      <div class="study-side">
        <section class="card study-run">
          <h2>{t('study.title')}</h2>
          <p>{t('study.what')}</p>
          {role === 'viewer' ? null : <Run whenDone={again} />}
        </section>
        {role === 'viewer' ? null : (
          <section class="card study-run">
            <h2>{t('study.recordedTitle')}</h2>
            <p>{t('study.recordedWhat')}</p>
            <Evaluate whenDone={again} />
          </section>
        )}
        <section class="card">
          <h2>{t('study.made')}</h2>
          <Trouble problem={list.problem} retry={list.retry} />
          {list.value !== null && items.length === 0 ? <p class="hint">{t('study.none')}</p> : null}
          <ul class="study-list">
            {items.map((item) => (
              <li key={item.id}>
                <a href={addressOf('study', item.id)} aria-current={item.id === chosen ? 'true' : undefined}>
                  <strong>{t('study.one', { n: item.id })}</strong>
                  <span>{date(item.made_utc_ms)}</span>
                  <span>
                    {t(item.subjects === 1 ? 'study.ofOne' : 'study.of', { n: item.subjects })}
                    {` · ${item.seed === null ? t('study.recorded') : t('study.seedOf', { n: item.seed })}`}
                  </span>
                </a>
              </li>
            ))}
          </ul>
        </section>
      </div>
      {chosen === null ? null : <Chosen key={chosen} id={chosen} asked={part !== null} role={role} whenGone={again} />}
    </div>
  );
}

function Run({ whenDone }: { whenDone: () => void }) {
  const [subjects, setSubjects] = useState(String(paperSubjects));
  const [seed, setSeed] = useState('1');
  const work = useJob('study', (job) => {
    whenDone();
    if (job.result?.kind === 'study') go(addressOf('study', job.result.study));
  });
  const asked = { subjects: readWhole(subjects, 1, subjectsMost), seed: readWhole(seed, 0, seedMost) };
  const start = () => {
    if (asked.subjects !== null && asked.seed !== null) void work.start({ kind: 'study', subjects: asked.subjects, seed: asked.seed });
  };
  return (
    <Form label={t('study.title')} onSend={start}>
      <div class="study-fields">
        <Field label={t('study.subjects')} hint={`1–${subjectsMost}`} value={subjects} numeric most={2} disabled={work.busy} onValue={setSubjects} />
        <Field label={t('study.seed')} hint={t('study.seedHint')} value={seed} numeric most={10} disabled={work.busy} onValue={setSeed} />
      </div>
      <button type="submit" class="plain primary" disabled={work.busy || asked.subjects === null || asked.seed === null}>
        {t('study.start')}
      </button>
      <Progress work={work} label={t('study.walking')} />
      <Trouble problem={work.problem} />
    </Form>
  );
}

/** Sessions of people: chosen by day and patient, as for a download. */
function Evaluate({ whenDone }: { whenDone: () => void }) {
  const sessions = useSessionChoice();
  const work = useJob('study_recorded', (job) => {
    whenDone();
    if (job.result?.kind === 'study_recorded') go(addressOf('study', job.result.study));
  });
  const start = () => void work.start({ kind: 'study_recorded', ...sessions.asked });
  return (
    <Form label={t('study.recordedTitle')} onSend={start}>
      <div class="study-fields">
        <SessionChoiceFields of={sessions} disabled={work.busy} />
      </div>
      <button type="submit" class="plain primary" disabled={work.busy}>
        {t('study.evaluate')}
      </button>
      <Progress work={work} label={t('study.evaluating')} />
      <Trouble problem={work.problem} />
    </Form>
  );
}

/** One study. `asked`: by a press or by its link, so it comes into view, on a narrow screen from below the forms. */
function Chosen({ id, asked, role, whenGone }: { id: number; asked: boolean; role: string; whenGone: () => void }) {
  const answer = useQuery(() => rest('GET /api/v1/studies/{id}', { path: { id } }), [id]);
  const head = useRef<HTMLElement>(null);
  const [sure, setSure] = useState(false);
  const removal = useJob('delete_study', () => {
    whenGone();
    go(addressOf('study'), true);
  });
  const study = answer.value;
  useEffect(() => {
    if (asked) head.current?.scrollIntoView({ block: 'start' });
  }, [asked, study !== null]);
  return (
    <div class="study-detail">
      <Trouble problem={answer.problem} retry={answer.retry} />
      {study === null ? null : (
        <>
          <section class="card study-head" ref={head}>
            <h2>{t('study.one', { n: id })}</h2>
            <p>
              {study.report.virtual_subjects ? t('study.sessions', { n: study.sessions.length }) : t('study.ofPeople')}{' '}
              <a href={addressOf('sessions')}>{t('study.toSessions')}</a>
            </p>
            {role === 'viewer' || removal.busy ? null : sure ? (
              <div class="form-buttons">
                <span>{study.report.virtual_subjects ? t('study.sure', { n: study.sessions.length }) : t('study.sureRecorded')}</span>
                <button type="button" class="plain" onClick={() => void removal.start({ kind: 'delete_study', study: id })}>
                  {t('sessions.delete')}
                </button>
                <button type="button" class="quiet" onClick={() => setSure(false)}>
                  {t('common.cancel')}
                </button>
              </div>
            ) : (
              <button type="button" class="plain" onClick={() => setSure(true)}>
                {t('study.delete')}
              </button>
            )}
            <Progress work={removal} label={t('study.deleting')} />
            <Trouble problem={removal.problem} />
          </section>
          <StudyReportView study={study} />
        </>
      )}
    </div>
  );
}
