// A number with two buttons.
import type { TaskRange } from '../../contract/rest.gen';
import { t } from '../../text/text';

interface StepperProps {
  label: string;
  text: string;
  range: Pick<TaskRange, 'least' | 'most'>;
  value: number;
  step: (by: 1 | -1) => void;
}
export function Stepper({ label, text, range, value, step }: StepperProps) {
  return (
    <div class="stepper" role="group" aria-label={label}>
      <span class="stepper-label">{label}</span>
      <button
        type="button"
        class="plain"
        aria-label={t('guided.less', { what: label })}
        disabled={value <= range.least + 1e-6}
        onClick={() => step(-1)}
      >
        −
      </button>
      <span class="stepper-value num">{text}</span>
      <button
        type="button"
        class="plain"
        aria-label={t('guided.more', { what: label })}
        disabled={value >= range.most - 1e-6}
        onClick={() => step(1)}
      >
        +
      </button>
    </div>
  );
}
