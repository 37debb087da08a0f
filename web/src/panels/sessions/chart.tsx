// The course of chosen columns. uPlot comes with this panel only, so that the first screen stays small.
import { useEffect, useRef } from 'preact/hooks';
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import type { SignalName } from '../../contract/signals.gen';
import { useSettings } from '../../text/settings';
import { plain, shownAs, t, words, withUnit } from '../../text/text';
import { strips, type Curve } from './curves';
import type { Samples } from '../../contract/rest.gen';
import { zigzag } from './model';
import './chart.css';

/** Distinguishable without colour too: the dash differs. */
const dashes: readonly number[][] = [[], [8, 4], [2, 3], [10, 3, 2, 3]];
const height_px = { one: 260, several: 150 };

interface Look {
  width_px: number;
  height_px: number;
  colour: (name: string) => string;
}

/** One strip: curves of one unit, the unit at the axis. `time` and `columns` are a zigzag of exactly these curves. */
function options(rows: readonly Curve[], { width_px, height_px: height, colour }: Look): uPlot.Options {
  const { unit } = shownAs(rows[0]!.name, rows[0]!.unit);
  const strokes = ['--accent', '--ink', '--ink-soft', '--series'].map(colour);
  const line = { stroke: colour('--line'), width: 1 };
  const axis = { stroke: colour('--ink-soft'), grid: line, ticks: line, font: '12px system-ui, sans-serif' };
  const label = { label: unit === '' ? ' ' : unit, labelSize: 22, labelFont: '600 13px system-ui, sans-serif' }; // a blank keeps strips aligned
  return {
    width: width_px,
    height,
    scales: { x: { time: false } },
    axes: [
      { ...axis, values: (_u, ticks) => ticks.map((tick) => `${plain(tick)} s`) },
      { ...axis, ...label, size: 52, values: (_u, ticks) => ticks.map(plain) },
    ],
    legend: { show: true, live: true },
    cursor: { drag: { x: true, y: false }, sync: { key: 'session' } },
    series: [
      { label: t('walk.time'), value: (_u, value) => (value === null ? '–' : `${plain(value)} s`) },
      ...rows.map((row, i) => ({
        label: words(row.title),
        stroke: strokes[i % strokes.length]!,
        width: 2,
        dash: [...dashes[i % dashes.length]!],
        points: { show: false },
        value: (_u: uPlot, value: number | null) => (value === null ? '–' : withUnit(plain(value), unit)),
      })),
    ],
  };
}

function strip(rows: readonly Curve[], samples: Samples, look: Look, element: HTMLElement): uPlot {
  const { factor } = shownAs(rows[0]!.name, rows[0]!.unit);
  const [time, ...columns] = zigzag(
    samples,
    rows.map((row) => row.name),
  );
  const scaled = columns.map((column) => column.map((value) => (value === null ? null : value * factor)));
  return new uPlot(options(rows, look), [time, ...scaled] as uPlot.AlignedData, element);
}

export function Chart({ samples, names }: { samples: Samples; names: readonly SignalName[] }) {
  const { language, theme } = useSettings();
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const element = box.current;
    if (element === null) return;
    let plots: uPlot[] = [];
    const groups = strips(names);
    const height = groups.length > 1 ? height_px.several : height_px.one;
    const clear = () => plots.forEach((plot) => plot.destroy());
    const draw = () => {
      clear();
      const style = getComputedStyle(element);
      const look = { width_px: element.clientWidth, height_px: height, colour: (name: string) => style.getPropertyValue(name).trim() };
      plots = groups.map((rows) => strip(rows, samples, look, element));
    };
    draw();
    const watch = new ResizeObserver(() => plots.forEach((plot) => plot.setSize({ width: element.clientWidth, height })));
    watch.observe(element);
    const dark = matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', draw);
    return () => {
      watch.disconnect();
      dark.removeEventListener('change', draw);
      clear();
    };
  }, [samples, names, language, theme]); // the colours are read when it is drawn
  return <div ref={box} class="chart" role="img" aria-label={t('sessions.chart')} />;
}
