// Who did what, newest first, in sentences. Only read.
import { useEffect, useState } from 'preact/hooks';
import { useQuery } from '../../link/query';
import { rest, wholeList, type Problem } from '../../link/rest';
import { date, t, words } from '../../text/text';
import { Trouble } from '../../ui/field';
import { detail, patientOf, refusal, sentence, type Names, type Row } from './audit_text';

const pageSize = 50;

export function AuditSection() {
  const newest = useQuery(() => rest('GET /api/v1/audit', { query: { limit: pageSize } }), []);
  const chain = useQuery(() => rest('GET /api/v1/audit/check'), []);
  const [older, setOlder] = useState<{ items: readonly Row[]; next: string | null } | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const next = older === null ? (newest.value?.next ?? null) : older.next;
  const more = async () => {
    if (next === null) return;
    const answer = await rest('GET /api/v1/audit', { query: { limit: pageSize, cursor: next } });
    setProblem(answer.ok ? null : answer.problem);
    if (answer.ok) setOlder((before) => ({ items: [...(before?.items ?? []), ...answer.value.items], next: answer.value.next }));
  };
  const items = [...(newest.value?.items ?? []), ...(older?.items ?? [])];
  const names = useNames(items);
  return (
    <section class="card">
      <h2>{t('settings.audit')}</h2>
      <p class="hint">{t('audit.hint')}</p>
      {chain.value?.first_wrong != null ? (
        <p class="form-error" role="alert">
          {t('audit.broken', { n: chain.value.first_wrong })}
        </p>
      ) : null}
      <Trouble problem={newest.problem ?? problem} retry={newest.problem ? newest.retry : () => void more()} />
      <ul class="rows audit">
        {items.map((row) => (
          <Line key={row.id} row={row} names={names} />
        ))}
      </ul>
      {next !== null ? (
        <button type="button" class="plain" onClick={() => void more()}>
          {t('audit.older')}
        </button>
      ) : null}
    </section>
  );
}

function Line({ row, names }: { row: Row; names: Names }) {
  const [changed, why] = [detail(row), refusal(row)];
  return (
    <li>
      <div class="row-text">
        <strong>{sentence(row, names)}</strong>
        {changed === null ? null : <span>{changed}</span>}
        {why === null ? null : (
          <span class="audit-refused">
            {t('audit.refused')}: {why}
          </span>
        )}
      </div>
      <div class="row-text audit-when">
        <span class="num">{date(row.utc_ms)}</span>
        {/^[\d.:a-f%]+$/.test(row.address) ? <span>{row.address}</span> : null}
      </div>
    </li>
  );
}

/** Names of people, and codes of the patients in these rows: the log holds no code, so that it outlives a deleted patient. */
function useNames(items: readonly Row[]): Names {
  const users = useQuery(() => wholeList((query) => rest('GET /api/v1/users', { query })), []);
  const steps = useQuery(() => rest('GET /api/v1/calibration'), []);
  const [codes, setCodes] = useState<ReadonlyMap<number, string | null>>(new Map());
  const wanted = [...new Set(items.map(patientOf))].filter((id) => id !== null && !codes.has(id)) as number[];
  useEffect(() => {
    let gone = false;
    const ask = async () => {
      for (const id of wanted) {
        const answer = await rest('GET /api/v1/patients/{id}', { path: { id } });
        if (gone) return;
        setCodes((before) => new Map(before).set(id, answer.ok ? answer.value.code : null));
      }
    };
    void ask();
    return () => void (gone = true);
  }, [wanted.join()]);
  return {
    patient: (id) => codes.get(id) ?? null,
    step: (name) => {
      const item = steps.value?.items.find((one) => one.name === name);
      return item ? words(item.title) : null;
    },
    person: (user) =>
      user === ''
        ? t('audit.somebody')
        : user === 'local'
          ? t('audit.thisComputer')
          : user === 'hoist-server'
            ? t('audit.theHoist')
            : (users.value?.items.find((one) => one.user === user)?.display_name ?? user),
  };
}
