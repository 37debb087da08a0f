/** What tests may do to the stand-in server. */
export interface FakeServer {
  url: string;
  /** What it pretends to be, and the messages that it has got. */
  hoist: {
    mode: string;
    faults: number;
    task: { task: string } | null;
    patient: { code: string } | null;
    commands: { type: string; mode?: string; exercise?: object | null; path?: object }[];
  };
  /** Who is in control: 0 for nobody. */
  lease: { holder: number };
  /** Long work that was asked for. */
  jobs: { kind: string; asked?: object }[];
  /** What runs ends now: by itself it takes `jobs_ms`. */
  finishJobs: () => void;
  /** The next job of this kind fails with this reason. */
  failNext: (kind: string, reason: string) => void;
  /** Messages of this type are refused from now on. */
  refuse: (type: string, reason: string) => void;
  /** The rehearsal is in another state. */
  rehearse: (state: object) => void;
  /** A marker of session 3 is this result. */
  markRehearsal: (result: object) => void;
  /** This fault is in force, until hoist.faults is 0 again. */
  fault: (name: string) => void;
  /** Pages that connect from now on have this role. */
  as: (role: string) => void;
  /** Live values that are other than in health. */
  trouble: (change: object) => void;
  event: (kind: string, more?: object) => void;
  close: () => Promise<void>;
}
export function startFakeServer(options?: {
  port?: number;
  dist?: string;
  signedIn?: boolean;
  pins?: boolean;
  jobs_ms?: number;
  set_up?: { needed: boolean; switch_on: boolean; seconds_left: number };
}): Promise<FakeServer>;
