// One study: Tables II and III beside the paper's, paired tests, drawings, what was assumed and what comes out.
import type { ComponentChildren } from 'preact';
import { metrics } from '../../contract/metrics.gen';
import type { Study } from '../../contract/rest.gen';
import { address } from '../../link/rest';
import { addressOf } from '../../router';
import type { TextKey } from '../../text/en';
import { reasonText } from '../../text/server';
import { study as texts } from '../../text/study';
import { addTexts, degrees, fixed, quantity, t, words } from '../../text/text';
import { Scroll } from '../../ui/scroll';
import { runMark, sessionOf, type Report, type StudyTable } from './model';

addTexts(texts);

const titles: Record<StudyTable['figure'], { title: TextKey; help: TextKey }> = {
  C: { title: 'study.table2', help: 'study.table2Help' },
  J_N: { title: 'study.table3', help: 'study.table3Help' },
};

const drawingTexts: Readonly<Record<string, { title: TextKey; alt: TextKey }>> = {
  'figure-2': { title: 'study.figure2', alt: 'study.figure2Alt' },
  'figure-7': { title: 'study.figure7', alt: 'study.figure7Alt' },
  'figure-8': { title: 'study.figure8', alt: 'study.figure8Alt' },
};

export function StudyReportView({ study }: { study: Study }) {
  const { report } = study;
  return (
    <>
      {report.tables.map((table) => (
        <section class="card" key={table.figure}>
          <h2>{t(titles[table.figure].title)}</h2>
          <p class="hint">{t(titles[table.figure].help)}</p>
          <FigureTable study={study} table={table} />
        </section>
      ))}
      <section class="card">
        <h2>{t('study.paired')}</h2>
        <p class="hint">{t('study.pairedHelp')}</p>
        <Paired report={report} />
      </section>
      {report.left_out.length === 0 ? null : <LeftOut report={report} />}
      <section class="card">
        <h2>{t('study.others')}</h2>
        <Others report={report} />
      </section>
      <div class="study-texts">
        {report.assumed === null ? null : <Assumed report={report} />}
        <Findings report={report} />
      </div>
      {study.drawings.map((name) => {
        const texts = drawingTexts[name];
        if (texts === undefined) return null;
        return (
          <section class="card" key={name}>
            <h2>{t(texts.title)}</h2>
            <Scroll class="study-drawing" label={t(texts.title)}>
              <img src={address('GET /api/v1/studies/{id}/drawings/{name}', { path: { id: study.id, name } })} alt={t(texts.alt)} />
            </Scroll>
          </section>
        );
      })}
    </>
  );
}

function Grid({ label, children }: { label: string; children: ComponentChildren }) {
  return (
    <Scroll class="study-scroll" label={label}>
      <table>{children}</table>
    </Scroll>
  );
}

function FigureTable({ study, table }: { study: Study; table: StudyTable }) {
  const { runs } = study.report;
  const number = (value: number | null | undefined) => fixed(value, table.decimals);
  return (
    <Grid label={t(titles[table.figure].title)}>
      <thead>
        <tr>
          <th rowSpan={2} scope="col">
            {t('study.subject')}
          </th>
          <th colSpan={runs.length} scope="colgroup">
            {t('study.here')}
          </th>
          <th colSpan={runs.length} scope="colgroup" class="paper">
            {t('study.paper')}
          </th>
        </tr>
        <tr>
          {runs.map((run) => (
            <th key={run.run} scope="col">
              {runMark(run)}
            </th>
          ))}
          {runs.map((run, i) => (
            <th key={run.run} scope="col" class={i === 0 ? 'paper' : undefined}>
              {runMark(run)}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {table.subjects.map((subject, row) => (
          <tr key={row}>
            <th scope="row">{subject === '-' ? row + 1 : subject}</th>
            {runs.map(({ run }, i) => {
              const value = table.own[i]?.[row];
              const session = sessionOf(study, subject, run);
              return (
                <td key={run} class="num">
                  {session === null || value === null ? number(value) : <a href={addressOf('sessions', session)}>{number(value)}</a>}
                </td>
              );
            })}
            {runs.map(({ run }, i) => (
              <td key={run} class={i === 0 ? 'num paper' : 'num'}>
                {number(table.paper[i]?.[row])}
              </td>
            ))}
          </tr>
        ))}
      </tbody>
      <tfoot>
        <tr>
          <th scope="row">{t('study.mean')}</th>
          {runs.map(({ run }, i) => (
            <td key={run} class="num">
              {number(table.own_mean[i])}
            </td>
          ))}
          {runs.map(({ run }, i) => (
            <td key={run} class={i === 0 ? 'num paper' : 'num'}>
              {number(table.paper_mean[i])}
            </td>
          ))}
        </tr>
      </tfoot>
    </Grid>
  );
}

type Test = Report['compared'][number]['own'];

function Paired({ report }: { report: Report }) {
  const cells = (test: Test, decimals: number, paper: boolean) =>
    test.pairs === 0
      ? [
          <td colSpan={3} class={paper ? 'paper' : undefined}>
            {t('study.noPairs')}
          </td>,
        ]
      : [
          <td class={paper ? 'num paper' : 'num'}>
            {fixed(test.mean_first, decimals)} → {fixed(test.mean_second, decimals)}
          </td>,
          <td class="num">{t('study.up', { up: test.up, n: test.pairs })}</td>,
          <td class="num">{fixed(test.p, 3)}</td>,
        ];
  return (
    <Grid label={t('study.paired')}>
      <thead>
        <tr>
          <th rowSpan={2} scope="col">
            {t('study.runs')}
          </th>
          {['study.here', 'study.paper'].map((key) => (
            <th key={key} colSpan={3} scope="colgroup" class={key === 'study.paper' ? 'paper' : undefined}>
              {t(key as TextKey)}
            </th>
          ))}
        </tr>
        <tr>
          {[false, true].map((paper) => [
            <th scope="col" class={paper ? 'paper' : undefined}>
              {t('study.means')}
            </th>,
            <th scope="col">{t('study.risen')}</th>,
            <th scope="col">p</th>,
          ])}
        </tr>
      </thead>
      <tbody>
        {report.compared.map((one) => (
          <tr key={`${one.figure}${one.from}-${one.to}`}>
            <th scope="row">
              {one.figure === 'C' ? 'C' : 'J'}, {one.from} → {one.to}
            </th>
            {cells(one.own, one.decimals, false)}
            {cells(one.paper, one.decimals, true)}
          </tr>
        ))}
      </tbody>
    </Grid>
  );
}

function Others({ report }: { report: Report }) {
  return (
    <Grid label={t('study.others')}>
      <thead>
        <tr>
          <th scope="col">{t('study.run')}</th>
          {report.runs.map((run) => (
            <th key={run.run} scope="col">
              {runMark(run)}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {report.others.map(({ figure, means }) => {
          const row = metrics.find(({ key }) => key === figure);
          if (row === undefined) return null;
          return (
            <tr key={figure}>
              <th scope="row">
                {words(row.title)}
                {row.unit === '' ? '' : `, ${row.unit}`}
              </th>
              {means.map((mean, i) => (
                <td key={i} class="num">
                  {fixed(mean === null ? null : mean * row.factor, row.digits)}
                </td>
              ))}
            </tr>
          );
        })}
      </tbody>
    </Grid>
  );
}

function LeftOut({ report }: { report: Report }) {
  return (
    <section class="card">
      <h2>{t('study.leftOut')}</h2>
      <ul>
        {report.left_out.map((one) => (
          <li key={`${one.subject}-${one.run}`}>
            {t('study.leftOutOne', { subject: one.subject, run: one.run })}{' '}
            {one.figure === null
              ? t('study.fewLaps', { n: fixed(one.laps, 1) })
              : `${one.figure}: ${reasonText(one.reason_code) ?? t('metric.notValid')}`}
          </li>
        ))}
      </ul>
    </section>
  );
}

function Assumed({ report }: { report: Report }) {
  const a = report.assumed!;
  const range = ([low, high]: readonly (number | undefined)[], decimals: number) => `${fixed(low, decimals)}–${fixed(high, decimals)}`;
  return (
    <section class="card">
      <h2>{t('study.assumed')}</h2>
      <p class="hint">{t('study.assumedHelp')}</p>
      <ul>
        <li>{t('study.assumedSpeed', { speed: `${range(a.wish_m_s, 2)} m/s`, preset: report.preset })}</li>
        <li>
          {t('study.assumedFollow', {
            share: range(a.anticipation_norm, 1),
            more: fixed(a.learning_norm, 2),
            late: quantity(a.trailing_s, 1, 's'),
          })}
        </li>
        <li>
          {t('study.assumedTherapist', {
            speed: quantity(a.therapist_m_s, 2, 'm/s'),
            late: quantity(a.therapist_delay_s, 2, 's'),
            aside: quantity(a.misjudgement_m * 100, 0, 'cm'),
            turned: degrees(a.misjudgement_rad, 0),
          })}
        </li>
        <li>{t('study.assumedOrthosis', { limp: fixed(a.limp_norm * 100, 0), sway: fixed(a.injured_sway_norm, 1) })}</li>
      </ul>
    </section>
  );
}

function Findings({ report }: { report: Report }) {
  const { c_square, c_led, j_ratio } = report.findings;
  return (
    <section class="card">
      <h2>{t('study.findings')}</h2>
      <ul>
        <li>{t('study.findSquare', { c: fixed(c_square, 2) })}</li>
        <li>{t('study.findLed', { c: fixed(c_led, 2) })}</li>
        <li>{t('study.findRatio', { n: fixed(j_ratio, 1) })}</li>
      </ul>
    </section>
  );
}
