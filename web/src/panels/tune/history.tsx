// What was changed, when and by whom. One tap sets a value back, within the same limits as any change.
import { useState } from 'preact/hooks';
import { params, type ParamInfo } from '../../contract/params.gen';
import type { ParameterHistory } from '../../contract/rest.gen';
import { useQuery } from '../../link/query';
import { rest } from '../../link/rest';
import type { Reply } from '../../link/socket';
import { useStore } from '../../link/store';
import { addressOf } from '../../router';
import { date, plain, shownAs, t, withUnit, words } from '../../text/text';
import { Trouble } from '../../ui/field';
import { Refusal, useRequest } from '../../ui/refusal';
import { groups } from './groups';
import '../../ui/rows.css';

type Change = ParameterHistory['items'][number];

const first = 10;
const most = 200;
/** Changes are written down shortly after they are in force. */
const look_ms = 4000;

/** Name of the account, or what changed it by itself. */
function whoOf({ actor, how }: Change): string {
  if (actor !== null) return actor.user === 'local' ? t('users.local') : actor.user;
  return how === 'trial_over' ? '' : t('history.unknown');
}

/** Closed until it is wanted: the settings themselves come first. */
export function HistoryCard({ send, locked }: { send: (row: ParamInfo, si: number) => Promise<Reply>; locked: (row: ParamInfo) => boolean }) {
  const [open, setOpen] = useState(false);
  const [limit, setLimit] = useState(first);
  const version = useStore((s) => s.parameterVersion);
  const ask = () => rest('GET /api/v1/parameters/history', { query: { limit } });
  const asked = useQuery(open ? ask : null, [limit, version], look_ms);
  const request = useRequest();
  // What has no place on this screen, such as dates of calibrations, is not set back here.
  const here = new Set(groups().flatMap((group) => group.rows.map(({ name }) => name as string)));
  const changes = (asked.value?.items ?? []).filter(({ name }) => here.has(name) || params.every((row) => row.name !== name));
  return (
    <details class="card tune-history" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{t('history.title')}</summary>
      <Trouble problem={asked.problem} retry={asked.retry} />
      <Refusal request={request} />
      {asked.value !== null && changes.length === 0 ? <p class="hint">{t('history.none')}</p> : null}
      <ul class="rows">
        {changes.map((change) => (
          <Row key={change.id} change={change} locked={locked} back={(row) => void request.ask(() => send(row, change.before)).then(asked.retry)} />
        ))}
      </ul>
      {asked.value?.next != null && limit < most ? (
        <button type="button" class="quiet" onClick={() => setLimit(limit === first ? 50 : most)}>
          {t('history.older')}
        </button>
      ) : null}
    </details>
  );
}

function Row({ change, locked, back }: { change: Change; locked: (row: ParamInfo) => boolean; back: (row: ParamInfo) => void }) {
  const row = params.find(({ name }) => name === change.name);
  const now = useStore((s) => s.parameters[change.name]);
  const show = shownAs(change.name, row?.unit ?? '');
  const value = (si: number) => withUnit(plain(si * show.factor), show.unit);
  const how = t(`history.how.${change.how}`, { name: change.source ?? '' });
  const who = whoOf(change);
  return (
    <li>
      <span class="row-text">
        <strong>{row === undefined ? t('profile.unknown') : words(row.title)}</strong>
        <span class="num">
          {value(change.before)} → {value(change.value)}
        </span>
        <span>
          {[date(change.utc_ms), who, how].filter((part) => part !== '').join(' · ')}
          {change.session === null ? null : (
            <>
              {' · '}
              <a href={addressOf('sessions', change.session)}>{t('sessions.one', { n: change.session })}</a>
            </>
          )}
        </span>
      </span>
      {row === undefined || now === change.before ? null : (
        <span class="row-buttons">
          <button
            type="button"
            class="plain"
            disabled={locked(row)}
            aria-label={t('history.backName', { name: words(row.title), value: value(change.before) })}
            onClick={() => back(row)}
          >
            {t('history.back', { value: value(change.before) })}
          </button>
        </span>
      )}
    </li>
  );
}
