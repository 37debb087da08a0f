// Settings suggested from a recorded session. Nothing is applied by itself: "Fill in" only writes into a setting's field, where a person applies it.
import { useState } from 'preact/hooks';
import { params, type ParamInfo } from '../../contract/params.gen';
import type { TuningAdvice } from '../../contract/rest.gen';
import { useQuery } from '../../link/query';
import { rest } from '../../link/rest';
import { useStore } from '../../link/store';
import { addressOf } from '../../router';
import { plain, shownAs, t, withUnit, words } from '../../text/text';
import { Trouble } from '../../ui/field';
import '../../ui/rows.css';
import { same } from './groups';

type Item = TuningAdvice['items'][number];

/** A session that was just walked appears within this time. */
const look_ms = 10_000;
const degrees = 180 / Math.PI;

/** A share as percent, a turn rate in degrees per second. */
const measure = (value: number, unit: string): string =>
  unit === 'rad/s' ? `${plain(Math.round(value * degrees * 100) / 100)} °/s` : `${plain(Math.round(value * 1000) / 10)} %`;

/** Closed until it is wanted. Of the newest session. */
export function AdviceCard({ takeOver, locked }: { takeOver: (row: ParamInfo, si: number) => void; locked: (row: ParamInfo) => boolean }) {
  const [open, setOpen] = useState(false);
  const newest = useQuery(open ? () => rest('GET /api/v1/sessions', { query: { limit: 1 } }) : null, [], look_ms);
  const session = newest.value?.items[0]?.id ?? null;
  const asked = useQuery(open && session !== null ? () => rest('GET /api/v1/sessions/{id}/tuning-advice', { path: { id: session } }) : null, [
    session,
  ]);
  const advice = asked.value;
  return (
    <details class="card tune-advice" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{t('advice.title')}</summary>
      <Trouble problem={newest.problem ?? asked.problem} retry={newest.problem === null ? asked.retry : newest.retry} />
      {newest.value !== null && session === null ? <p class="hint">{t('advice.noSession')}</p> : null}
      {advice === null ? null : (
        <>
          <p class="hint">
            <a href={addressOf('sessions', advice.session)}>{t('sessions.one', { n: advice.session })}</a>
            {': '}
            {t('advice.from', { standing: Math.round(advice.standing_s), walking: Math.round(advice.walking_s) })} {t('advice.only')}
          </p>
          <ul class="rows">
            {advice.items.map((item) => (
              <Row key={item.name} item={item} locked={locked} takeOver={takeOver} />
            ))}
          </ul>
        </>
      )}
    </details>
  );
}

function Row({ item, locked, takeOver }: { item: Item; locked: (row: ParamInfo) => boolean; takeOver: (row: ParamInfo, si: number) => void }) {
  const row = params.find(({ name }) => name === item.name);
  const now = useStore((s) => s.parameters[item.name]);
  if (row === undefined) return null;
  const show = shownAs(row.name, row.unit);
  const value = (si: number) => withUnit(plain(si * show.factor), show.unit);
  const { now: was, suggested, measured, effect_now, effect_then } = item;
  const given = was !== null && suggested !== null && measured !== null && effect_now !== null && effect_then !== null;
  const stays = given && same(suggested, was);
  // What was measured holds for the value of that session only.
  const moved = given && now !== undefined && !same(now, was);
  const done = given && now !== undefined && same(now, suggested);
  return (
    <li>
      <span class="row-text">
        <strong>{words(row.title)}</strong>
        {given ? (
          <>
            <span class="num">{stays ? t('advice.stays', { value: value(suggested) }) : `${value(was)} → ${value(suggested)}`}</span>
            <span>
              {t('advice.measured', { what: words(item.measures), value: measure(measured, item.measured_unit) })}
              {stays
                ? null
                : ` ${t('advice.expected', {
                    what: words(item.effect),
                    now: measure(effect_now, item.measured_unit),
                    then: measure(effect_then, item.measured_unit),
                  })}`}
            </span>
            {moved ? <span>{done ? t('advice.inForce') : t('advice.moved', { value: value(now) })}</span> : null}
          </>
        ) : (
          <span>{t('advice.none', { why: item.reason === null ? '' : words(item.reason) })}</span>
        )}
      </span>
      {given && !stays && !moved ? (
        <span class="row-buttons">
          <button
            type="button"
            class="plain"
            disabled={locked(row)}
            aria-label={t('advice.takeName', { name: words(row.title), value: value(suggested) })}
            onClick={() => takeOver(row, suggested)}
          >
            {t('advice.take')}
          </button>
        </span>
      ) : null}
    </li>
  );
}
