// How long recordings are kept. A rule is stored only after the person has seen what it deletes.
import { useEffect, useState } from 'preact/hooks';
import type { Job, RetentionResult, RetentionRule } from '../../contract/rest.gen';
import { notify } from '../../link/console';
import { useJob } from '../../link/jobs';
import { useQuery } from '../../link/query';
import { rest, type Problem } from '../../link/rest';
import { date, readNumber, t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { HoldButton } from '../../ui/hold_button';
import { Progress } from '../../ui/progress';
import { size } from './backup';

const confirmHold_ms = 2000;
const usualDays = 365;
const usualShare_percent = 50;
const numberDigits = 5;

const same = (a: RetentionRule, b: RetentionRule) => a.days === b.days && a.disk_percent === b.disk_percent && a.needs_backup === b.needs_backup;
const isOn = (rule: RetentionRule) => rule.days !== null || rule.disk_percent !== null;
const resultOf = (job: Job): RetentionResult | null =>
  job.result?.kind === 'preview_retention' || job.result?.kind === 'retention' ? job.result : null;

interface LimitProps {
  label: string;
  unit: string;
  value: number | null;
  usual: number;
  onValue: (value: number | null) => void;
}

/** A limit that can be off: a box, and its number while it is on. */
function Limit({ label, unit, value, usual, onValue }: LimitProps) {
  const [typed, setTyped] = useState(String(value ?? usual));
  const type = (text: string) => {
    setTyped(text);
    onValue(readNumber(text));
  };
  return (
    <div>
      <label class="check">
        <input type="checkbox" checked={value !== null} onChange={(event) => onValue(event.currentTarget.checked ? readNumber(typed) : null)} />
        <span>{label}</span>
      </label>
      {value === null ? null : <Field label={unit} value={typed} most={numberDigits} numeric onValue={type} />}
    </div>
  );
}

export function RetentionSection() {
  const stored = useQuery(() => rest('GET /api/v1/retention'), []);
  const [wish, setWish] = useState<RetentionRule | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [seen, setSeen] = useState<RetentionResult | null>(null);
  const preview = useJob('preview_retention', (job) => setSeen(resultOf(job)));
  const deletion = useJob('retention', (job) => {
    setSeen(null);
    notify('info', t('retention.deleted', { n: resultOf(job)?.sessions ?? 0 }), true);
  });
  const now = stored.value;
  useEffect(() => {
    if (now !== null) setWish({ days: now.days, disk_percent: now.disk_percent, needs_backup: now.needs_backup });
  }, [now]);
  const change = (part: Partial<RetentionRule>) => wish !== null && setWish({ ...wish, ...part });
  const shown = seen !== null && wish !== null && same(seen.rule, wish) ? seen : null;
  const save = async () => {
    if (wish === null || now === null) return;
    const answer = await rest('PUT /api/v1/retention', { body: wish, etag: now.etag });
    setProblem(answer.ok ? null : answer.problem);
    if (answer.ok) notify('info', 'retention.saved');
    if (answer.ok || answer.problem.code === 'outdated') stored.retry();
  };
  if (wish === null || now === null)
    return (
      <section class="card">
        <h2>{t('settings.retention')}</h2>
        {stored.problem === null ? <p class="hint">{t('common.loading')}</p> : <Trouble problem={stored.problem} retry={stored.retry} />}
      </section>
    );
  const changed = !same(wish, now);
  return (
    <section class="card">
      <h2>{t('settings.retention')}</h2>
      <p class="hint">{t(isOn(now) ? 'retention.on' : 'retention.off')}</p>
      <Form onSend={() => void preview.start({ kind: 'preview_retention', rule: wish })}>
        <Limit
          label={t('retention.days')}
          unit={t('retention.daysNumber')}
          value={wish.days}
          usual={usualDays}
          onValue={(days) => change({ days })}
        />
        <Limit
          label={t('retention.share')}
          unit={t('retention.shareNumber')}
          value={wish.disk_percent}
          usual={usualShare_percent}
          onValue={(disk_percent) => change({ disk_percent })}
        />
        <label class="check">
          <input type="checkbox" checked={wish.needs_backup} onChange={(event) => change({ needs_backup: event.currentTarget.checked })} />
          <span>{t('retention.backup')}</span>
        </label>
        <p class="hint">{t('retention.never')}</p>
        <div class="form-buttons">
          <button type="submit" class="big" disabled={preview.busy || deletion.busy || !isOn(wish)}>
            {t('retention.preview')}
          </button>
          <button type="button" class="big primary" disabled={!changed || (isOn(wish) && shown === null)} onClick={() => void save()}>
            {t('common.save')}
          </button>
        </div>
      </Form>
      <Progress work={preview} label={t('retention.counting')} />
      <Progress work={deletion} label={t('retention.deleting')} />
      <Trouble problem={problem ?? preview.problem ?? deletion.problem} />
      {shown === null ? null : <Shown plan={shown} />}
      {shown !== null && shown.sessions > 0 && !changed ? (
        <HoldButton
          label={t('retention.hold')}
          hint={t('retention.holdHint')}
          hold_ms={confirmHold_ms}
          disabled={deletion.busy}
          onDone={() => void deletion.start({ kind: 'retention' })}
        />
      ) : null}
    </section>
  );
}

/** What a rule deletes, and what it leaves although it is old. */
function Shown({ plan }: { plan: RetentionResult }) {
  return (
    <div role="status">
      <p>
        <strong>
          {plan.sessions === 0
            ? t('retention.none')
            : t('retention.some', {
                n: plan.sessions,
                from: date(plan.from_utc_ms),
                to: date(plan.to_utc_ms),
                size: size(plan.bytes),
              })}
        </strong>
      </p>
      {plan.without_backup > 0 ? <p>{t('retention.kept', { n: plan.without_backup })}</p> : null}
      {plan.excess_bytes > 0 ? <p>{t('retention.excess', { size: size(plan.excess_bytes) })}</p> : null}
      <p class="hint">{t('retention.used', { size: size(plan.used_bytes), disk: size(plan.disk_bytes) })}</p>
    </div>
  );
}
