// The course of chosen columns. uPlot comes with this panel only, so that the first screen stays small.
import { useEffect, useRef } from 'preact/hooks';
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import type { SignalName } from '../../contract/signals.gen';
import { useSettings } from '../../text/settings';
import { plain, shownAs, t, words } from '../../text/text';
import { curves } from './curves';
import { zigzag, type Samples } from './model';

/** Distinguishable without colour too: the dash differs. */
const dashes: readonly number[][] = [[], [8, 4], [2, 3], [10, 3, 2, 3]];
const height_px = 260;

export function Chart({ samples, names }: { samples: Samples; names: readonly SignalName[] }) {
  const { language, theme } = useSettings();
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const element = box.current;
    if (element === null) return;
    let plot: uPlot | null = null;
    const draw = () => {
      plot?.destroy();
      const style = getComputedStyle(element);
      const colour = (name: string) => style.getPropertyValue(name).trim();
      const strokes = ['--accent', '--ink', '--ink-soft', '--series'].map(colour);
      const rows = names.map((name) => curves.find((curve) => curve.name === name)!);
      const shows = rows.map((row) => shownAs(row.name, row.unit));
      const [time, ...values] = zigzag(samples, names);
      const scaled = values.map((column, i) => column.map((value) => (value === null ? null : value * shows[i]!.factor)));
      const axis = { stroke: colour('--ink-soft'), grid: { stroke: colour('--line'), width: 1 }, ticks: { stroke: colour('--line'), width: 1 }, font: '12px system-ui, sans-serif' };
      plot = new uPlot(
        {
          width: element.clientWidth,
          height: height_px,
          scales: { x: { time: false } },
          axes: [{ ...axis, values: (_u, ticks) => ticks.map((tick) => `${plain(tick)} s`) }, { ...axis, size: 56, values: (_u, ticks) => ticks.map(plain) }],
          legend: { show: true, live: true },
          cursor: { drag: { x: true, y: false } },
          series: [
            { label: t('walk.time'), value: (_u, value) => (value === null ? '–' : `${plain(value)} s`) },
            ...rows.map((row, i) => ({
              label: words(row.title),
              stroke: strokes[i % strokes.length]!,
              width: 2,
              dash: [...dashes[i % dashes.length]!],
              points: { show: false },
              value: (_u: uPlot, value: number | null) => (value === null ? '–' : `${plain(value)} ${shows[i]!.unit}`),
            })),
          ],
        },
        [time, ...scaled] as uPlot.AlignedData,
        element,
      );
    };
    draw();
    const watch = new ResizeObserver(() => plot?.setSize({ width: element.clientWidth, height: height_px }));
    watch.observe(element);
    const dark = matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', draw);
    return () => {
      watch.disconnect();
      dark.removeEventListener('change', draw);
      plot?.destroy();
    };
  }, [samples, names, language, theme]); // the colours are read when it is drawn
  return <div ref={box} class="chart" role="img" aria-label={t('sessions.chart')} />;
}

export default Chart;
