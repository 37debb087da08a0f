// The instruction as a small drawing. Decoration: the text beside it says the same.
import type { StepName } from './model';
import '../../ui/hoist_picture.css';

const side = (lean: number) => {
  const x = 96 * Math.sin(lean);
  const y = 40 - 96 * Math.cos(lean);
  return { x, y };
};

function Side({ lean = 0, patient = false, both = false }: { lean?: number; patient?: boolean; both?: boolean }) {
  const tip = side(lean);
  return (
    <g>
      <path class="p-frame" d="M-50 46H58" />
      <circle class="p-wheel" cx="-8" cy="60" r="13" />
      <circle class="p-castor" cx="52" cy="64" r="7" />
      {both ? <path class="p-strut far" d={`M0 40L${-tip.x} ${tip.y}`} /> : null}
      <path class="p-strut" d={`M0 40L${tip.x} ${tip.y}`} />
      {patient ? (
        <g transform={`translate(${tip.x} ${tip.y})`}>
          <ellipse class="p-body" cy="4" rx="15" ry="18" />
          <circle class="p-head" cy="-20" r="10" />
        </g>
      ) : null}
      {both ? <path class="p-arrow thin" d="M-16-72H34M26-80 36-72 26-64" /> : null}
    </g>
  );
}

function Above({ turned = 0 }: { turned?: number }) {
  return (
    <g>
      <path class="p-frame" d="M-52-52V56H52V-52" />
      <rect class="p-wheel" x="-60" y="-6" width="12" height="34" rx="4" />
      <rect class="p-wheel" x="48" y="-6" width="12" height="34" rx="4" />
      <circle class="p-castor" cx="-52" cy="-52" r="5" />
      <circle class="p-castor" cx="52" cy="-52" r="5" />
      <path class="p-bar" d="M-40 0H40" transform={`rotate(${turned})`} />
    </g>
  );
}

export function StepPicture({ step, part }: { step: StepName; part: number | null }) {
  const strips = ['M-40-72H40', 'M-40 72H40', 'M-74-40V40', 'M74-40V40'];
  return (
    <svg class="calibrate-picture" viewBox="-92 -96 184 176" aria-hidden="true">
      {step === 'zero' ? <Side /> : null}
      {step === 'neutral' ? <Side patient /> : null}
      {step === 'gyro' ? (
        <g>
          <Above />
          <circle class="p-limit p-none" r="30" />
        </g>
      ) : null}
      {step === 'strut_length' || (step === 'struts' && (part ?? 0) === 0) ? <Side lean={0.26} both /> : null}
      {step === 'struts' && part === 1 ? (
        <g>
          <Above />
          <path class="p-bar" d="M-22 0H58" />
          <path class="p-arrow thin" d="M-10-24H34M24-34 35-24 24-14" />
        </g>
      ) : null}
      {step === 'strut_spacing' || (step === 'struts' && part === 2) ? (
        <g>
          <Above turned={-22} />
          <path class="p-arrow thin" d="M44-14A46 46 0 0 0 24-40M36-41 23-41 24-28" />
        </g>
      ) : null}
      {step === 'wheel_radius' || step === 'encoders' ? (
        <g transform="translate(0 16) scale(0.8)">
          <Above />
          <path class="p-arrow thin" d="M0-66V-112M-11-101 0-113 11-101" />
        </g>
      ) : null}
      {step === 'track' ? (
        <g transform="scale(0.78)">
          <Above />
          <path class="p-arrow thin" d="M84-40A92 92 0 1 0 92 10M76-24 85-42 100-28" />
        </g>
      ) : null}
      {step === 'square' ? (
        <g>
          <path class="p-limit p-none" d="M-58-64H58V56H-58Z" />
          <path class="p-arrow thin" d="M-58 56V-10M-69 2-58-11-47 2" />
          <g transform="translate(-58 56) scale(0.28)">
            <Above />
          </g>
        </g>
      ) : null}
      {step === 'bumpers' ? (
        <g>
          <Above />
          {strips.map((d, i) => (
            <path key={d} class={i === part ? 'p-strip on' : 'p-strip'} d={d} />
          ))}
        </g>
      ) : null}
    </svg>
  );
}
