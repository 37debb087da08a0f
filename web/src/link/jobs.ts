// Long work of the server: started here, followed until it has ended.
import { useEffect, useRef, useState } from 'preact/hooks';
import type { Job, JobRequest } from '../contract/rest.gen';
import { rest, wholeList, type Problem } from './rest';

const follow_ms = 500;
export const ended = (job: Job | null): boolean => job === null || job.state === 'done' || job.state === 'failed' || job.state === 'cancelled';

/** What a job's end says to the person: nothing after a good end, else as of a refused request. */
export const jobProblem = (job: Job): Problem | null =>
  job.state === 'failed' ? { status: 0, code: job.reason_code ?? 'internal', errors: [], refusals: [], wait_s: null } : null;

export interface Work {
  /** The newest state of the job; null: none. */
  job: Job | null;
  busy: boolean;
  problem: Problem | null;
  start: (request: JobRequest) => Promise<void>;
  cancel: () => void;
}

/** One job of a screen. One of `kind` that runs already, from before the screen was opened or from another screen, is followed as well. */
export function useJob(kind: JobRequest['kind'], whenDone?: (job: Job) => void): Work {
  const [job, setJob] = useState<Job | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const here = useRef(true);
  const done = useRef(whenDone);
  done.current = whenDone;
  const take = (next: Job) => {
    if (!here.current) return;
    setJob(next);
    setProblem(jobProblem(next));
    if (next.state === 'done') done.current?.(next);
  };
  useEffect(() => {
    here.current = true;
    void wholeList((query) => rest('GET /api/v1/jobs', { query })).then((answer) => {
      const running = answer.ok ? answer.value.items.find((one) => one.kind === kind && !ended(one)) : undefined;
      if (running !== undefined && here.current) setJob((now) => now ?? running);
    });
    return () => void (here.current = false);
  }, []);
  const id = job?.id ?? null;
  const over = ended(job);
  useEffect(() => {
    if (id === null || over) return undefined;
    let waits = false;
    const timer = window.setInterval(() => {
      if (waits) return;
      waits = true;
      void rest('GET /api/v1/jobs/{id}', { path: { id } }).then((answer) => {
        waits = false;
        if (answer.ok) take(answer.value);
        // The server has forgotten it: it has ended without telling.
        else if (answer.problem.status === 404) {
          setJob(null);
          setProblem(answer.problem);
        }
      });
    }, follow_ms);
    return () => window.clearInterval(timer);
  }, [id, over]);
  const start = async (request: JobRequest) => {
    setProblem(null);
    const answer = await rest('POST /api/v1/jobs', { body: request });
    if (!here.current) return;
    if (answer.ok) take(answer.value);
    else setProblem(answer.problem);
  };
  const cancel = () => {
    if (id !== null) void rest('DELETE /api/v1/jobs/{id}', { path: { id } });
  };
  return { job, busy: !over, problem, start, cancel };
}
