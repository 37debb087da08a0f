// Every figure of a session, by groups, or why it is not valid.
import { metricGroups, metrics as rows, type MetricInfo } from '../../contract/metrics.gen';
import type { Metrics } from '../../contract/rest.gen';
import { reasonText } from '../../text/server';
import { fixed, t, words } from '../../text/text';

export function valueText({ key, unit, factor, digits }: MetricInfo, metrics: Metrics): string | null {
  const value = metrics[key];
  if (value === null) return null;
  return `${fixed(value * factor, digits)}${unit === '' || unit === '°' ? unit : ` ${unit}`}`;
}

export function AllFigures({ metrics }: { metrics: Metrics }) {
  return (
    <details class="all-figures">
      <summary>{t('metric.all')}</summary>
      {metricGroups.map((group) => (
        <section key={group.name}>
          <h3>{words(group.title)}</h3>
          <dl>
            {rows
              .filter((row) => row.group === group.name)
              .map((row) => {
                const value = valueText(row, metrics);
                return (
                  <div key={row.key}>
                    <dt>{words(row.title)}</dt>
                    {value === null ? (
                      <dd class="absent">{reasonText(metrics.computed[row.key].reason_code) ?? t('metric.notValid')}</dd>
                    ) : (
                      <dd class="num">{value}</dd>
                    )}
                  </div>
                );
              })}
          </dl>
        </section>
      ))}
    </details>
  );
}
