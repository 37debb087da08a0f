// The floor from above: planned figure dashed, walked path solid, the hoist at its place. x to the right, y up, like the paper's figures.
import { useEffect, useRef } from 'preact/hooks';
import { live, useFrame } from '../link/live';
import type { Exercise } from '../contract/messages.gen';
import { fixed, t } from '../text/text';
import { fit, patternPoints, type Frame, type Point } from './geometry';

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
  const px = (x: number) => width / 2 + (x - frame.centre_x) * frame.pixels_per_m;
  const py = (y: number) => height / 2 - (y - frame.centre_y) * frame.pixels_per_m;
  ctx.clearRect(0, 0, width, height);

  // A grid of one metre, or of five when the floor is large.
  const step = frame.pixels_per_m < 18 ? 5 : 1;
  const half_x = width / 2 / frame.pixels_per_m;
  const half_y = height / 2 / frame.pixels_per_m;
  ctx.strokeStyle = colour.faint;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (let x = Math.ceil((frame.centre_x - half_x) / step) * step; x <= frame.centre_x + half_x; x += step) {
    ctx.moveTo(px(x), 0);
    ctx.lineTo(px(x), height);
  }
  for (let y = Math.ceil((frame.centre_y - half_y) / step) * step; y <= frame.centre_y + half_y; y += step) {
    ctx.moveTo(0, py(y));
    ctx.lineTo(width, py(y));
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
      if (i === 0) ctx.moveTo(px(x[i]!), py(y[i]!));
      else ctx.lineTo(px(x[i]!), py(y[i]!));
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
  ctx.strokeStyle = colour.accent;
  ctx.lineWidth = 3;
  line(drawing.x, drawing.y);

  if (drawing.pose === null) return;
  ctx.save();
  ctx.translate(px(drawing.pose.x_m), py(drawing.pose.y_m));
  ctx.rotate(-drawing.pose.psi_rad);
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

export function FloorView({ exercise }: { exercise: Exercise }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const pattern = useRef<Point[]>([]);
  useEffect(() => {
    pattern.current = patternPoints(exercise);
  }, [exercise]);
  const drawn = useRef({ what: '', at_ms: -Infinity });
  useFrame((now_ms) => {
    if (canvas.current === null) return;
    // A hoist that stands is not drawn anew, except once a second: colours and size may have changed.
    const r = live.record;
    const what = r === null ? '' : `${r.fused_x_m.toFixed(3)} ${r.fused_y_m.toFixed(3)} ${r.fused_psi_rad.toFixed(3)} ${live.pathLife} ${live.path.x.length} ${exercise.shape}`;
    if (what === drawn.current.what && now_ms - drawn.current.at_ms < 1000) return;
    drawn.current = { what, at_ms: now_ms };
    const x = live.path.x.latest();
    const y = live.path.y.latest();
    const bounds: Point[] = [...pattern.current];
    // Every tenth point is enough to find the bounds.
    for (let i = 0; i < x.length; i += 10) bounds.push({ x: x[i]!, y: y[i]! });
    if (live.record !== null) bounds.push({ x: live.record.fused_x_m, y: live.record.fused_y_m });
    const frame = fit(bounds, canvas.current.clientWidth, canvas.current.clientHeight);
    drawFloor(canvas.current, { pattern: pattern.current, x, y, pose: r === null ? null : { x_m: r.fused_x_m, y_m: r.fused_y_m, psi_rad: r.fused_psi_rad } }, frame);
  });
  return <canvas ref={canvas} class="floor" role="img" aria-label={t('floor.label')} />;
}
