/** What tests may do to the stand-in server. */
export interface FakeServer {
  url: string;
  /** What it pretends to be, and the messages that it has got. */
  hoist: { commands: { type: string }[] };
  event: (kind: string, more?: object) => void;
  close: () => Promise<void>;
}
export function startFakeServer(options?: { port?: number; dist?: string; signedIn?: boolean }): Promise<FakeServer>;
