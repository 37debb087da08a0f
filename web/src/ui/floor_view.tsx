// The floor from above: planned figure dashed, walked path solid, the hoist at its place. x up, y to the left: at its start mark the hoist
// looks up, as the joystick does (DECISIONS 40).
import { useMemo, useRef } from 'preact/hooks';
import { live, useFrame } from '../link/live';
import { useTopic } from '../link/wants';
import type { Exercise } from '../contract/rest.gen';
import { fixed, t } from '../text/text';
import { fit, onScreen, patternPoints, polesOf, type Frame, type Point } from './geometry';
import './floor_view.css';

/** Reads the colours of the style sheet, so that light and dark are decided in one place. */
function colours(element: Element) {
  const style = getComputedStyle(element);
  const read = (name: string) => style.getPropertyValue(name).trim();
  return { ink: read('--ink'), faint: read('--line'), soft: read('--ink-soft'), accent: read('--accent'), card: read('--card') };
}

/** Footprint of the hoist for the drawing: half width and half length, m. */
const half_width_m = 0.35;
const front_m = 0.45;
const rear_m = 0.35;

export function prepare(canvas: HTMLCanvasElement): CanvasRenderingContext2D | null {
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const width = Math.round(canvas.clientWidth * ratio);
  const height = Math.round(canvas.clientHeight * ratio);
  if (width === 0 || height === 0) return null;
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const ctx = canvas.getContext('2d');
  ctx?.setTransform(ratio, 0, 0, ratio, 0, 0);
  return ctx;
}

export interface FloorDrawing {
  pattern: readonly Point[];
  poles: readonly Point[];
  x: ArrayLike<number>;
  y: ArrayLike<number>;
  pose: { x_m: number; y_m: number; psi_rad: number } | null;
}

export function drawFloor(canvas: HTMLCanvasElement, drawing: FloorDrawing, frame: Frame): void {
  const ctx = prepare(canvas);
  if (ctx === null) return;
  const colour = colours(canvas);
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  const place = (x: number, y: number) => onScreen({ x, y }, frame, width, height);
  ctx.clearRect(0, 0, width, height);

  // A grid of one metre, or of five when the floor is large.
  const step = frame.pixels_per_m < 18 ? 5 : 1;
  const half_x = height / 2 / frame.pixels_per_m;
  const half_y = width / 2 / frame.pixels_per_m;
  ctx.strokeStyle = colour.faint;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (let x = Math.ceil((frame.centre_x - half_x) / step) * step; x <= frame.centre_x + half_x; x += step) {
    const { top } = place(x, 0);
    ctx.moveTo(0, top);
    ctx.lineTo(width, top);
  }
  for (let y = Math.ceil((frame.centre_y - half_y) / step) * step; y <= frame.centre_y + half_y; y += step) {
    const { left } = place(0, y);
    ctx.moveTo(left, 0);
    ctx.lineTo(left, height);
  }
  ctx.stroke();

  // The scale, at the lower left.
  ctx.strokeStyle = colour.soft;
  ctx.fillStyle = colour.soft;
  ctx.lineWidth = 2;
  ctx.beginPath();
  ctx.moveTo(14, height - 14);
  ctx.lineTo(14 + step * frame.pixels_per_m, height - 14);
  ctx.stroke();
  ctx.font = '13px system-ui, sans-serif';
  ctx.fillText(t('floor.metre', { n: fixed(step, 0) }), 14, height - 20);

  const line = (x: ArrayLike<number>, y: ArrayLike<number>) => {
    ctx.beginPath();
    for (let i = 0; i < x.length; i++) {
      if (Number.isNaN(x[i])) continue; // positions are missing here: not joined
      const { left, top } = place(x[i]!, y[i]!);
      if (i === 0 || Number.isNaN(x[i - 1])) ctx.moveTo(left, top);
      else ctx.lineTo(left, top);
    }
    ctx.stroke();
  };
  ctx.lineJoin = 'round';
  if (drawing.pattern.length > 1) {
    ctx.setLineDash([9, 8]);
    ctx.lineWidth = 2;
    line(
      drawing.pattern.map((p) => p.x),
      drawing.pattern.map((p) => p.y),
    );
    ctx.setLineDash([]);
  }
  ctx.fillStyle = colour.soft;
  for (const { x, y } of drawing.poles) {
    const { left, top } = place(x, y);
    ctx.beginPath();
    ctx.arc(left, top, Math.max(4, 0.06 * frame.pixels_per_m), 0, 2 * Math.PI);
    ctx.fill();
  }
  ctx.strokeStyle = colour.accent;
  ctx.lineWidth = 3;
  line(drawing.x, drawing.y);

  if (drawing.pose === null) return;
  ctx.save();
  const at = place(drawing.pose.x_m, drawing.pose.y_m);
  ctx.translate(at.left, at.top);
  ctx.rotate(-drawing.pose.psi_rad - Math.PI / 2);
  const m = frame.pixels_per_m;
  // The frame is open in front, where the patient walks out of it.
  ctx.strokeStyle = colour.ink;
  ctx.lineWidth = Math.max(3, 0.06 * m);
  ctx.beginPath();
  ctx.moveTo(front_m * m, -half_width_m * m);
  ctx.lineTo(-rear_m * m, -half_width_m * m);
  ctx.lineTo(-rear_m * m, half_width_m * m);
  ctx.lineTo(front_m * m, half_width_m * m);
  ctx.stroke();
  ctx.fillStyle = colour.accent;
  ctx.beginPath();
  ctx.moveTo(0.3 * m, 0);
  ctx.lineTo(-0.14 * m, 0.17 * m);
  ctx.lineTo(-0.14 * m, -0.17 * m);
  ctx.closePath();
  ctx.fill();
  ctx.restore();
}

/** Start position and heading of a figure. */
function startOf(points: readonly Point[]): FloorDrawing['pose'] {
  const [first, second] = points;
  if (first === undefined || second === undefined) return null;
  return { x_m: first.x, y_m: first.y, psi_rad: Math.atan2(second.y - first.y, second.x - first.x) };
}

/** With `planned` the hoist is drawn at the figure's start, without a walked path. */
export function FloorView({ exercise, planned = false }: { exercise: Exercise; planned?: boolean }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const pattern = useMemo(() => patternPoints(exercise), [exercise]);
  const poles = useMemo(() => polesOf(exercise), [exercise]);
  const drawn = useRef({ what: '', at_ms: -Infinity });
  useTopic('pose', 20);
  useFrame((now_ms) => {
    if (canvas.current === null) return;
    // At standstill it is redrawn only once a second, since colours and size may have changed.
    const r = live.with('pose');
    const pose_now = r === null ? '' : [r.fused_x_m, r.fused_y_m, r.fused_psi_rad].map((value) => value.toFixed(3)).join(' ');
    const what = [pose_now, live.pathLife, live.path.x.length, JSON.stringify(exercise), planned].join(' ');
    if (what === drawn.current.what && now_ms - drawn.current.at_ms < 1000) return;
    drawn.current = { what, at_ms: now_ms };
    const driven = r === null ? null : { x_m: r.fused_x_m, y_m: r.fused_y_m, psi_rad: r.fused_psi_rad };
    const pose = planned ? startOf(pattern) : driven;
    const x = planned ? [] : live.path.x;
    const y = planned ? [] : live.path.y;
    const bounds: Point[] = [...pattern];
    // Every tenth point is enough to find the bounds.
    for (let i = 0; i < x.length; i += 10) bounds.push({ x: x[i]!, y: y[i]! });
    if (pose !== null) bounds.push({ x: pose.x_m, y: pose.y_m });
    const frame = fit(bounds, canvas.current.clientWidth, canvas.current.clientHeight);
    drawFloor(canvas.current, { pattern, poles, x, y, pose }, frame);
  });
  return <canvas ref={canvas} class="floor" role="img" aria-label={t('floor.label')} />;
}
