// Seconds until a next try is allowed, counted down.
import { useEffect, useState } from 'preact/hooks';
import type { Problem } from '../link/rest';

/** Whole seconds left after this refusal; 0 = now. Counts by the clock, so that a sleeping tablet is not behind. */
export function useWait(problem: Problem | null): number {
  const [left_s, setLeft] = useState(0);
  useEffect(() => {
    const wait_s = problem?.wait_s ?? 0;
    const end_ms = performance.now() + wait_s * 1000;
    const show = () => setLeft(Math.max(0, Math.ceil((end_ms - performance.now()) / 1000)));
    show();
    if (wait_s === 0) return undefined;
    const timer = window.setInterval(show, 250);
    return () => window.clearInterval(timer);
  }, [problem]);
  return left_s;
}
