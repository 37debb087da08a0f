// Picture of the hoist: from above with the patient and the intent, from behind and from the side with the true strut angles.
import { useRef } from 'preact/hooks';
import { live, useFrame } from '../link/live';
import { useStore } from '../link/store';
import { useTopic } from '../link/wants';
import { degrees, t } from '../text/text';
import './hoist_picture.css';

/** Share of the picture for a full lean; enlarged, because 13 cm would hardly show. */
const fullLean_px = 58;
const fullTurn_deg = 38;
const strut_px = 96;
/** The mechanical stop of the struts, paper section II. */
const stop_rad = (15 * Math.PI) / 180;

/** End of a strut that stands on (x, y) and leans by `tilt` to the right. */
const tip = (x: number, y: number, tilt_rad: number) => ({ x: x + strut_px * Math.sin(tilt_rad), y: y - strut_px * Math.cos(tilt_rad) });
const wedge = (x: number, y: number, from_rad: number, to_rad: number, radius: number) => {
  const place = (angle_rad: number) => `${x + radius * Math.sin(angle_rad)} ${y - radius * Math.cos(angle_rad)}`;
  return `M${x} ${y}L${place(from_rad)}A${radius} ${radius} 0 0 1 ${place(to_rad)}Z`;
};

/** The intent as a bent arrow from the patient, who stands at `start`; its tip stays inside of the picture. */
export function wishArrow(lean: number, turn: number, start = 0): string {
  if (Math.abs(lean) < 0.02 && Math.abs(turn) < 0.02) return '';
  const bend = -turn * 60; // a left turn bends to the left of the picture
  const ahead = (lean < -0.02 ? 20 : -20) - 62 * lean;
  const end = Math.max(-80 - start, Math.min(68 - start, ahead));
  return `M0 0Q0 ${n1(end * 0.6)} ${n1(bend)} ${n1(end)}`;
}

function put(element: SVGElement | null, name: string, value: string): void {
  if (element !== null && element.getAttribute(name) !== value) element.setAttribute(name, value);
}

const n1 = (value: number) => value.toFixed(1);

export function HoistPicture() {
  const deadLean = useStore((s) => s.parameters.lean_dead_band_norm ?? 0.05);
  const leanRange_rad = useStore((s) => s.parameters.lean_range_rad ?? 0.1571);
  const neutral_m = useStore((s) => s.parameters.neutral_lean_m ?? 0);
  const strut_m = useStore((s) => s.parameters.strut_length_m ?? 0.8);
  const refs = useRef<Record<string, SVGElement | null>>({});
  const ref = (name: string) => (element: SVGElement | null) => {
    refs.current[name] = element;
  };

  useTopic('posture', 20);
  useTopic('intent', 20);
  useFrame(() => {
    const r = live.with('posture', 'intent');
    if (r === null) return;
    const e = refs.current;
    const left = { alpha: r.left_alpha_rad - r.base_alpha_rad, beta: r.left_beta_rad - r.base_beta_rad };
    const right = { alpha: r.right_alpha_rad - r.base_alpha_rad, beta: r.right_beta_rad - r.base_beta_rad };
    // From above: the patient moves with the lean and turns with the pelvis.
    const shift = -r.lean_norm * fullLean_px;
    put(e.patient ?? null, 'transform', `translate(0 ${n1(shift)}) rotate(${n1(-r.turn_norm * fullTurn_deg)})`);
    const dead = Math.abs(r.lean_norm) <= deadLean;
    const start = shift - 14;
    const arrow = wishArrow(dead ? 0 : r.lean_norm, r.turn_norm, start);
    put(e.arrow ?? null, 'd', arrow);
    put(e.arrow ?? null, 'transform', `translate(0 ${n1(start)})`);
    put(e.arrow ?? null, 'visibility', arrow === '' ? 'hidden' : 'visible');
    // From behind: left is left, leaning right goes to the right.
    const l = tip(-44, 40, left.beta);
    const rr = tip(44, 40, right.beta);
    put(e.behindLeft ?? null, 'd', `M-44 40L${n1(l.x)} ${n1(l.y)}`);
    put(e.behindRight ?? null, 'd', `M44 40L${n1(rr.x)} ${n1(rr.y)}`);
    put(e.behindBar ?? null, 'd', `M${n1(l.x)} ${n1(l.y)}L${n1(rr.x)} ${n1(rr.y)}`);
    put(e.behindHead ?? null, 'transform', `translate(${n1((l.x + rr.x) / 2)} ${n1((l.y + rr.y) / 2)})`);
    put(e.behindBase ?? null, 'transform', `rotate(${n1((r.base_beta_rad * 180) / Math.PI)} 0 40)`);
    // From the right side: forward is to the right.
    const a = tip(0, 40, left.alpha);
    const b = tip(0, 40, right.alpha);
    put(e.sideLeft ?? null, 'd', `M0 40L${n1(a.x)} ${n1(a.y)}`);
    put(e.sideRight ?? null, 'd', `M0 40L${n1(b.x)} ${n1(b.y)}`);
    put(e.sideHead ?? null, 'transform', `translate(${n1((a.x + b.x) / 2)} ${n1((a.y + b.y) / 2)})`);
    put(e.sideBase ?? null, 'transform', `rotate(${n1((r.base_alpha_rad * 180) / Math.PI)} 0 40)`);
    if (e.sideText) e.sideText.textContent = degrees((left.alpha + right.alpha) / 2);
    if (e.behindText) e.behindText.textContent = degrees((left.beta + right.beta) / 2);
  });

  const neutral_rad = Math.atan(neutral_m / strut_m);
  const standing_rad = Math.atan(deadLean * Math.tan(leanRange_rad));
  return (
    <figure class="picture" aria-label={t('picture.label')}>
      <div class="picture-part">
        <svg viewBox="-80 -92 160 172" aria-hidden="true">
          <path class="p-frame" d="M-52-52V56H52V-52" />
          <rect class="p-wheel" x="-60" y="-6" width="12" height="34" rx="4" />
          <rect class="p-wheel" x="48" y="-6" width="12" height="34" rx="4" />
          <circle class="p-castor" cx="-52" cy="-52" r="5" />
          <circle class="p-castor" cx="52" cy="-52" r="5" />
          <rect class="p-zone" x="-49" y={-deadLean * fullLean_px} width="98" height={2 * deadLean * fullLean_px} />
          <path class="p-limit" d={`M-34 ${-fullLean_px}H34M-34 ${fullLean_px - 6}H34`} />
          <g ref={ref('patient')}>
            <path class="p-bar" d="M-40 0H40" />
            <ellipse class="p-body" rx="25" ry="14" />
            <circle class="p-head" r="9" />
          </g>
          <path ref={ref('arrow')} class="p-arrow" marker-end="url(#wish-tip)" />
          <defs>
            <marker id="wish-tip" viewBox="0 0 10 10" refX="5" refY="5" markerWidth="3.2" markerHeight="3.2" orient="auto">
              <path class="p-arrow-tip" d="M0 0 10 5 0 10z" />
            </marker>
          </defs>
        </svg>
        <figcaption>
          {t('picture.above')}
          <span class="legend">{t('picture.standing')}</span>
        </figcaption>
      </div>
      <div class="picture-part">
        <svg viewBox="-80 -92 160 172" aria-hidden="true">
          <path class="p-range" d={wedge(-44, 40, -stop_rad, stop_rad, strut_px + 8)} />
          <path class="p-range" d={wedge(44, 40, -stop_rad, stop_rad, strut_px + 8)} />
          <g ref={ref('behindBase')}>
            <path class="p-frame" d="M-58 46H58" />
            <rect class="p-wheel" x="-64" y="44" width="12" height="26" rx="4" />
            <rect class="p-wheel" x="52" y="44" width="12" height="26" rx="4" />
          </g>
          <path ref={ref('behindLeft')} class="p-strut" d="M-44 40V-56" />
          <path ref={ref('behindRight')} class="p-strut" d="M44 40V-56" />
          <path ref={ref('behindBar')} class="p-bar" d="M-44-56H44" />
          <g ref={ref('behindHead')} transform="translate(0 -56)">
            <ellipse class="p-body" cy="4" rx="24" ry="18" />
            <circle class="p-head" cy="-20" r="10" />
          </g>
          <text ref={ref('behindText')} class="p-text" x="78" y="-78" text-anchor="end" />
        </svg>
        <figcaption>{t('picture.behind')}</figcaption>
      </div>
      <div class="picture-part">
        <svg viewBox="-80 -92 160 172" aria-hidden="true">
          <path class="p-range" d={wedge(0, 40, -stop_rad, stop_rad, strut_px + 8)} />
          <path class="p-zone" d={wedge(0, 40, neutral_rad - standing_rad, neutral_rad + standing_rad, strut_px + 8)} />
          <g ref={ref('sideBase')}>
            <path class="p-frame" d="M-50 46H58" />
            <circle class="p-wheel" cx="-8" cy="60" r="13" />
            <circle class="p-castor" cx="52" cy="64" r="7" />
          </g>
          <path ref={ref('sideLeft')} class="p-strut far" d="M0 40V-56" />
          <path ref={ref('sideRight')} class="p-strut" d="M0 40V-56" />
          <g ref={ref('sideHead')} transform="translate(0 -56)">
            <ellipse class="p-body" cy="4" rx="15" ry="18" />
            <circle class="p-head" cy="-20" r="10" />
          </g>
          <path class="p-forward" d="M-74-80H-48M-54-85-48-80-54-75" />
          <text ref={ref('sideText')} class="p-text" x="78" y="-78" text-anchor="end" />
        </svg>
        <figcaption>{t('picture.side')}</figcaption>
      </div>
    </figure>
  );
}
