// The connection and the state together, in virtual time: STOP on a dead connection, and how old what is shown is.
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { layoutHash } from '../src/contract/messages.gen';
import { signals, tickRecordBytes } from '../src/contract/signals.gen';
import type { SocketLike } from '../src/link/socket';

const sent: string[] = [];
let socket: SocketLike & { bufferedAmount: number };
vi.mock('../src/link/ticketed', () => ({
  openTicketed: () =>
    (socket = {
      binaryType: '',
      readyState: 1,
      bufferedAmount: 0,
      onopen: null,
      onclose: null,
      onmessage: null,
      onerror: null,
      send: (data) => {
        const message = JSON.parse(data) as { type: string; t?: number };
        sent.push(message.type);
        if (message.type === 'ping') pong?.(message.t!);
      },
      close: () => {},
    }),
}));

let begun_ms: number;
/** When STOP went over HTTP. */
let posts_ms: number[];
let pong: ((t: number) => void) | null;
let answers: boolean;
let page: typeof import('../src/link/console');
let store: (typeof import('../src/link/store'))['store'];

beforeEach(async () => {
  vi.useFakeTimers();
  vi.resetModules();
  vi.stubGlobal('window', globalThis);
  vi.stubGlobal('document', { addEventListener: () => {}, hidden: false });
  vi.stubGlobal('addEventListener', () => {});
  posts_ms = [];
  answers = false;
  pong = null;
  vi.stubGlobal('fetch', (address: string) => {
    if (address === '/api/v1/stop') posts_ms.push(performance.now() - begun_ms);
    return answers ? Promise.resolve(new Response('{"ok":true}')) : new Promise(() => {});
  });
  sent.length = 0;
  page = await import('../src/link/console');
  ({ store } = await import('../src/link/store'));
  page.startLink();
  socket.onopen?.({});
  begun_ms = performance.now();
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});
const stops = () => sent.filter((type) => type === 'stop').length;
/** A frightened person presses again and again. */
function hammer(each_ms: number, for_ms: number): void {
  for (let at_ms = 0; at_ms < for_ms; at_ms += each_ms) {
    page.stop();
    vi.advanceTimersByTime(each_ms);
  }
}

describe('STOP', () => {
  it('goes once over an open socket while the hoist has time to answer, then also over HTTP', () => {
    page.stop();
    expect([stops(), posts_ms.length]).toEqual([1, 0]);
    vi.advanceTimersByTime(300);
    expect([stops(), posts_ms.length]).toEqual([2, 1]);
  });

  it('pressed again and again on a dead socket goes over HTTP at the second press, and is reported as failed after 3 s', () => {
    hammer(200, 2800);
    expect(posts_ms[0]).toBe(200);
    expect(store.value).toMatchObject({ stopSent: true, stopFailed: false });
    hammer(200, 400);
    expect(store.value.stopFailed).toBe(true);
  });

  it('stays reported as failed while it is pressed again, until the server confirms one', async () => {
    hammer(3100, 3100);
    page.stop();
    expect(store.value).toMatchObject({ stopSent: true, stopFailed: true });
    answers = true;
    await vi.advanceTimersByTimeAsync(300);
    expect(store.value).toMatchObject({ stopSent: false, stopFailed: false });
    const posts = posts_ms.length;
    await vi.advanceTimersByTimeAsync(1000);
    expect(posts_ms.length).toBe(posts);
  });
});

describe('a driving command', () => {
  it('is left out while the browser still has some to send: it would arrive late', () => {
    const drives = () => sent.filter((type) => type === 'drive').length;
    expect([page.drive(1, 0, true), drives()]).toEqual([true, 1]);
    socket.bufferedAmount = 2049;
    expect([page.drive(1, 0, true), drives()]).toEqual([false, 1]);
    socket.bufferedAmount = 0;
    expect([page.drive(1, 0, true), drives()]).toEqual([true, 2]);
  });
});

describe('a start and the release of a stop', () => {
  it('tell what the screen had seen, also when a question about control came first', async () => {
    const messages: Record<string, unknown>[] = [];
    socket.send = (data) => {
      const message = JSON.parse(data) as { request?: number };
      messages.push(message);
      socket.onmessage?.({ data: JSON.stringify({ type: 'reply', request: message.request, ok: true }) });
    };
    const timeAt = signals.find(({ name }) => name === 'time_ns')!;
    let seen = 5_000_000_000;
    const show = () => {
      new DataView(frame).setBigUint64(16 + timeAt.offset, BigInt((seen += 10_000_000)), true);
      socket.onmessage?.({ data: frame });
    };
    socket.onmessage?.({ data: JSON.stringify({ type: 'lease', epoch: 1, holder: 9, mine: false, actor: null, asking: [] }) });
    // The person thinks for a while before control is taken.
    page.dialogs.askTakeOver = () => {
      show();
      return Promise.resolve(true);
    };
    show();
    for (const ask of [() => page.requestMode('user', null), () => page.acknowledge([])]) {
      messages.length = 0;
      expect((await ask()).ok).toBe(true);
      expect(messages.map(({ type }) => type)).toEqual(['lease_take', messages[1]?.type]);
      expect(messages[1]).toMatchObject({ echo: seen });
    }
    messages.length = 0;
    await page.endMotion();
    expect(messages[0]).not.toHaveProperty('echo');
  });
});

/** A connection in virtual time: when what is sent at a time arrives, of each direction; null: never. */
interface Way {
  up_ms: (at_ms: number) => number | null;
  down_ms: (at_ms: number) => number;
}
const frame_ms = 200;
const frame = (() => {
  const view = new DataView(new ArrayBuffer(16 + tickRecordBytes));
  view.setUint8(0, 1);
  view.setUint8(1, 1);
  view.setUint16(2, 1, true);
  view.setUint32(4, tickRecordBytes, true);
  view.setBigUint64(8, BigInt(`0x${layoutHash}`), true);
  return view.buffer;
})();
function run(for_ms: number, { up_ms, down_ms }: Way): void {
  const now = () => performance.now() - begun_ms;
  const { onmessage } = socket;
  const at = (then_ms: number, data: unknown) => setTimeout(() => onmessage?.({ data }), then_ms - now());
  pong = (t) => {
    const there_ms = up_ms(now());
    if (there_ms !== null) at(down_ms(there_ms), JSON.stringify({ type: 'pong', t }));
  };
  for (const end_ms = now() + for_ms; now() < end_ms;) {
    at(down_ms(now()), frame);
    vi.advanceTimersByTime(frame_ms);
  }
}
const delay =
  (ms: number): Way['down_ms'] =>
  (at_ms) =>
    at_ms + ms;
const good: Way = { up_ms: delay(50), down_ms: delay(50) };

describe('the age of what is shown', () => {
  it('stays fresh over a WiFi with a round trip of 100 ms and bursts of 300 ms', () => {
    const seen = new Set<string>();
    run(2000, good);
    const stop = store.subscribe(() => seen.add(store.value.data));
    // Nothing passes for 300 ms, now and then, at another time of the pings each time.
    const burst = (at_ms: number) => Math.max(at_ms + 50, at_ms - (at_ms % 1730) + (at_ms % 1730 < 300 ? 350 : 0));
    run(60_000, { up_ms: burst, down_ms: burst });
    stop();
    expect([...seen]).toEqual(['fresh']);
    expect(store.value.link).toBe('open');
  });

  it('is late and then gone when values come regularly, but late', () => {
    run(3000, good);
    expect(store.value).toMatchObject({ data: 'fresh', dataAge_s: 0, rtt_s: 0.1 });
    run(3000, { ...good, down_ms: delay(700) });
    expect(store.value.data).toBe('late');
    run(6000, { ...good, down_ms: delay(2000) });
    expect(store.value).toMatchObject({ data: 'gone', dataAge_s: 2, link: 'open' });
    run(3000, good);
    expect(store.value).toMatchObject({ data: 'fresh', rtt_s: 0.1 });
  });

  it('grows while nothing that is sent arrives, and ends with the connection', () => {
    run(3000, good);
    run(2000, { ...good, up_ms: () => null });
    expect(store.value.rtt_s).toBeGreaterThan(0.3); // driving is refused
    expect(store.value.data).not.toBe('fresh');
    run(2400, { ...good, up_ms: () => null });
    expect(store.value).toMatchObject({ link: 'lost', rtt_s: null });
  });
});
