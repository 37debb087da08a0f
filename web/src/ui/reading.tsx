// A number that follows the newest record, with its name and unit. Grey when the data are old.
import type { TickRecord } from '../contract/signals.gen';
import { useReading } from '../link/live';
import './reading.css';

export function Reading({ label, unit, read, rate_hz }: { label: string; unit?: string; read: (record: TickRecord) => string; rate_hz?: number }) {
  const text = useReading((record) => (record === null ? '–' : read(record)), rate_hz);
  return (
    <div class="reading">
      <span class="reading-label">{label}</span>
      <span class="reading-value">
        <span class="num">{text}</span>
        {unit ? <span class="reading-unit">{unit === '°' ? unit : ` ${unit}`}</span> : null}
      </span>
    </div>
  );
}
