// Who did what, newest first. Only read.
import { useState } from 'preact/hooks';
import type { AuditList } from '../../contract/rest.gen';
import { useQuery } from '../../link/query';
import { rest, type Problem } from '../../link/rest';
import { date, t, textOf } from '../../text/text';
import { Trouble } from '../../ui/field';

const pageSize = 50;
type Row = AuditList['items'][number];

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
          <li key={row.id}>
            <div class="row-text">
              <strong>{textOf(`audit.${row.action}`) ?? row.action.replaceAll('_', ' ')}</strong>
              <span>
                {row.user} · {row.address}
                {row.target === '' ? '' : ` · ${row.target}`}
              </span>
              {row.before !== null || row.after !== null ? (
                <span>
                  {row.before ?? '–'} → {row.after ?? '–'}
                </span>
              ) : null}
            </div>
            <div class="row-text audit-when">
              <span class="num">{date(row.utc_ms)}</span>
              <span>{/^(done|2\d\d)$/.test(row.result) ? '' : t('audit.refused')}</span>
            </div>
          </li>
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
