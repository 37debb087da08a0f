// A number that follows the newest sample, with its name and unit. Grey when the data are old.
import type { TopicName } from '../contract/rest.gen';
import type { SampleOf } from '../link/frame';
import { useReading } from '../link/live';
import type { Rate } from '../link/wants';
import './reading.css';

interface ReadingProps<T extends TopicName> {
  label: string;
  unit?: string;
  topic: T;
  read: (sample: SampleOf<T>) => string;
  rate_hz?: Rate;
}

export function Reading<T extends TopicName>({ label, unit, topic, read, rate_hz }: ReadingProps<T>) {
  const text = useReading(topic, (sample) => (sample === null ? '–' : read(sample)), rate_hz);
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
