// The floor from above while a line is drawn on it: a tap places a point, a drag moves one, arrow keys move the focused one.
import { useEffect, useRef, useState } from 'preact/hooks';
import { fixed, t } from '../../text/text';
import { beside_m, fit, onScreen, type Frame, type Point } from '../../ui/geometry';
import { edgeAt, grid_m, moved, onFloor, pointsMost, without, withPoint, type Draft, type Floor, type Judged } from './draft';

/** A finger is no finer. */
const touch_px = 24;
const edge_px = 14;

interface PlanProps {
  draft: Draft;
  floor: Floor;
  judged: Judged;
  selected: number | null;
  select: (index: number | null) => void;
  /** `begins`: the first change of a gesture, which Undo takes back as a whole. */
  change: (draft: Draft, begins: boolean) => void;
}

const text_m = (value: number) => `${fixed(value, 1)} m`;
export const pointLabel = (index: number, { x, y }: Point) => t('line.point', { n: index + 1, x: text_m(x), y: text_m(y) });

const arrows: Readonly<Record<string, Point>> = {
  ArrowUp: { x: grid_m, y: 0 },
  ArrowDown: { x: -grid_m, y: 0 },
  ArrowLeft: { x: 0, y: grid_m },
  ArrowRight: { x: 0, y: -grid_m },
};

function useSize() {
  const element = useRef<SVGSVGElement>(null);
  const [size, setSize] = useState({ width: 0, height: 0 });
  useEffect(() => {
    const svg = element.current;
    if (svg === null) return undefined;
    const observer = new ResizeObserver(() => setSize({ width: svg.clientWidth, height: svg.clientHeight }));
    observer.observe(svg);
    return () => observer.disconnect();
  }, []);
  return { element, ...size };
}

const cornersOf = ({ along_m, across_m }: Floor): Point[] => [
  { x: along_m / 2, y: across_m / 2 },
  { x: -along_m / 2, y: -across_m / 2 },
];

export function LinePlan({ draft, floor, judged, selected, select, change }: PlanProps) {
  const { element, width, height } = useSize();
  // One finger drags; another one, or a palm, moves nothing.
  const dragged = useRef<{ pointer: number; index: number; began: boolean; draft: Draft } | null>(null);
  const frame = fit([...cornersOf(floor), ...draft.points], width, height, 0.7, 1);
  const place = (point: Point) => onScreen(point, frame, width, height);
  const floorAt = (event: PointerEvent): Point => {
    const box = element.current!.getBoundingClientRect();
    return {
      x: frame.centre_x + (height / 2 - (event.clientY - box.top)) / frame.pixels_per_m,
      y: frame.centre_y + (width / 2 - (event.clientX - box.left)) / frame.pixels_per_m,
    };
  };
  const down = (event: PointerEvent) => {
    if (event.button !== 0 || dragged.current !== null) return;
    const at = floorAt(event);
    const away = draft.points.map((point) => Math.hypot(point.x - at.x, point.y - at.y) * frame.pixels_per_m);
    const nearest = away.indexOf(Math.min(...away));
    element.current?.setPointerCapture(event.pointerId);
    if (nearest >= 0 && away[nearest]! <= touch_px) {
      dragged.current = { pointer: event.pointerId, index: nearest, began: false, draft };
      select(nearest);
      return;
    }
    if (draft.points.length >= pointsMost) return;
    const index = edgeAt(draft, at, edge_px / frame.pixels_per_m) ?? draft.points.length;
    const next = withPoint(draft, onFloor(at, floor), index);
    dragged.current = { pointer: event.pointerId, index, began: true, draft: next };
    change(next, true);
    select(index);
  };
  const move = (event: PointerEvent) => {
    const drag = dragged.current;
    if (drag?.pointer !== event.pointerId) return;
    const to = onFloor(floorAt(event), floor);
    const from = drag.draft.points[drag.index]!;
    if (to.x === from.x && to.y === from.y) return;
    drag.draft = moved(drag.draft, drag.index, to);
    change(drag.draft, !drag.began);
    drag.began = true;
  };
  const up = (event: PointerEvent) => {
    if (dragged.current?.pointer === event.pointerId) dragged.current = null;
  };
  const key = (event: KeyboardEvent, index: number) => {
    const by = arrows[event.key];
    const point = draft.points[index]!;
    if (by !== undefined) change(moved(draft, index, onFloor({ x: point.x + by.x, y: point.y + by.y }, floor)), true);
    else if (event.key === 'Delete' || event.key === 'Backspace') {
      change(without(draft, index), true);
      select(null);
    } else return;
    event.preventDefault();
  };
  const path = judged.points.map((point) => place(point)).map(({ left, top }) => `${left.toFixed(1)},${top.toFixed(1)}`);
  return (
    <svg
      ref={element}
      class="line-plan"
      role="group"
      aria-label={t('line.plan')}
      onPointerDown={down}
      onPointerMove={move}
      onPointerUp={up}
      onPointerCancel={up}
    >
      {width > 0 ? <Room floor={floor} frame={frame} width={width} height={height} /> : null}
      <polyline class="line-drawn" points={path.join(' ')} />
      <Start points={judged.points} frame={frame} place={place} />
      {draft.points.map((point, index) => {
        const { left, top } = place(point);
        return (
          <g
            key={index}
            class={selected === index ? 'line-point selected' : 'line-point'}
            tabIndex={0}
            role="button"
            aria-label={pointLabel(index, point)}
            aria-pressed={selected === index}
            onFocus={() => select(index)}
            onKeyDown={(event) => key(event, index)}
          >
            <circle cx={left} cy={top} r={11} />
            <text x={left} y={top + 4}>
              {index + 1}
            </text>
          </g>
        );
      })}
    </svg>
  );
}

/** The free floor with its grid in metres, and how near the line may come to its edge. */
function Room({ floor, frame, width, height }: { floor: Floor; frame: Frame; width: number; height: number }) {
  const { along_m, across_m } = floor;
  const box = (inset_m: number) => {
    const from = onScreen({ x: along_m / 2 - inset_m, y: across_m / 2 - inset_m }, frame, width, height);
    return {
      x: from.left,
      y: from.top,
      width: Math.max(0, (across_m - 2 * inset_m) * frame.pixels_per_m),
      height: Math.max(0, (along_m - 2 * inset_m) * frame.pixels_per_m),
    };
  };
  const step = frame.pixels_per_m < 18 ? 5 : frame.pixels_per_m < 34 ? 2 : 1;
  const ticks = (side_m: number) => {
    const most = Math.floor(side_m / 2 / step);
    return Array.from({ length: 2 * most + 1 }, (_, i) => (i - most) * step);
  };
  const outer = box(0);
  return (
    <g class="line-room" aria-hidden="true">
      <rect class="line-floor" {...outer} />
      {ticks(along_m).map((x) => {
        const { top } = onScreen({ x, y: 0 }, frame, width, height);
        return (
          <g key={`x${x}`}>
            <line x1={outer.x} x2={outer.x + outer.width} y1={top} y2={top} />
            <text x={outer.x - 5} y={top + 4} text-anchor="end">
              {fixed(x, 0)}
            </text>
          </g>
        );
      })}
      {ticks(across_m).map((y) => {
        const { left } = onScreen({ x: 0, y }, frame, width, height);
        return (
          <g key={`y${y}`}>
            <line x1={left} x2={left} y1={outer.y} y2={outer.y + outer.height} />
            <text x={left} y={outer.y + outer.height + 16} text-anchor="middle">
              {fixed(y, 0)}
            </text>
          </g>
        );
      })}
      <rect class="line-edge" {...box(beside_m)} />
      <text x={outer.x - 5} y={outer.y - 10} text-anchor="end">
        m
      </text>
    </g>
  );
}

/** The hoist where the walk begins, looking along the line. */
function Start({ points, frame, place }: { points: readonly Point[]; frame: Frame; place: (point: Point) => { left: number; top: number } }) {
  const [first, second] = points;
  if (first === undefined || second === undefined) return null;
  const { left, top } = place(first);
  const turn = -Math.atan2(second.y - first.y, second.x - first.x) * (180 / Math.PI);
  const m = frame.pixels_per_m;
  // Open in front, where the patient walks out of it; as on the other floor views.
  return (
    <path
      class="line-start"
      aria-hidden="true"
      transform={`translate(${left} ${top}) rotate(${turn}) scale(${m})`}
      d="M -0.35 -0.45 L -0.35 0.35 L 0.35 0.35 L 0.35 -0.45"
    />
  );
}
