// One hook for a component's plain requests to the server.
import { useEffect, useState } from 'preact/hooks';
import type { Answer, Problem } from './rest';

export interface Query<T> {
  /** The last good answer; kept while it is requested again, and after a failure. Null without a request. */
  value: T | null;
  problem: Problem | null;
  retry: () => void;
}

/** Requests when the component appears, whenever `what` changes, and each `every_ms`. Outdated answers are dropped. Without a request (null) an
 * earlier answer is cleared. */
export function useQuery<T>(question: (() => Promise<Answer<T>>) | null, what: readonly unknown[], every_ms?: number): Query<T> {
  const [value, setValue] = useState<T | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [tries, setTries] = useState(0);
  const asks = question !== null;
  useEffect(() => {
    if (question === null) {
      setValue(null);
      setProblem(null);
      return undefined;
    }
    let waits = false;
    let gone = false;
    const ask = async () => {
      if (waits) return; // a slow server gets one question at a time
      waits = true;
      const answer = await question();
      waits = false;
      if (gone) return;
      if (answer.ok) setValue(answer.value);
      setProblem(answer.ok ? null : answer.problem);
    };
    void ask();
    const timer = every_ms === undefined ? null : window.setInterval(() => void ask(), every_ms);
    return () => {
      gone = true;
      if (timer !== null) window.clearInterval(timer);
    };
  }, [asks, ...what, tries]);
  return { value: asks ? value : null, problem: asks ? problem : null, retry: () => setTries((n) => n + 1) };
}
