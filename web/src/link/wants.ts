// Which live values the mounted components show: the union is what the page asks the server for.
import { useEffect } from 'preact/hooks';
import type { StreamRequest } from '../contract/messages.gen';
import type { TopicName } from '../contract/rest.gen';

export type Rate = NonNullable<StreamRequest['rate_hz']>;
/** Mode, alarms and whether values are old: always, on every screen. */
export const least_hz: Rate = 5;
const steps_hz: Rate = 100;

export class Wants {
  private readonly wanted = new Map<object, { topic: TopicName; rate_hz: Rate }>();
  private told: () => void = () => {};
  private due = false;
  private everyTick_ = false;

  /** Calls `change` after each change, once for all of one rendering. */
  onChange(change: () => void): void {
    this.told = change;
  }

  /** Returns what ends the wish. */
  add(topic: TopicName, rate_hz: Rate): () => void {
    const key = {};
    this.wanted.set(key, { topic, rate_hz });
    this.tell();
    return () => {
      this.wanted.delete(key);
      this.tell();
    };
  }

  /** A message for each step: while this page drives. */
  everyTick(on: boolean): void {
    if (this.everyTick_ === on) return;
    this.everyTick_ = on;
    this.tell();
  }

  get choice(): Omit<StreamRequest, 'type'> {
    const all = [...this.wanted.values()];
    const names = [...new Set(all.map((want) => want.topic))].sort();
    const topics: TopicName[] = names.includes('all') ? ['all'] : ['state', ...names.filter((name) => name !== 'state')];
    const rate_hz = all.reduce<Rate>((most, want) => (want.rate_hz > most ? want.rate_hz : most), this.everyTick_ ? steps_hz : least_hz);
    return { topics, rate_hz, every_tick: this.everyTick_ };
  }

  private tell(): void {
    if (this.due) return;
    this.due = true;
    queueMicrotask(() => {
      this.due = false;
      this.told();
    });
  }
}

export const wants = new Wants();

/** The values of this topic are received while the component is mounted. */
export function useTopic(topic: TopicName, rate_hz: Rate): void {
  useEffect(() => wants.add(topic, rate_hz), [topic, rate_hz]);
}
