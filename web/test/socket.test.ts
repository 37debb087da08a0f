import { beforeEach, describe, expect, it } from 'vitest';
import {
  backOffFirst_ms,
  backOffLast_ms,
  Link,
  ping_ms,
  replyWithin_ms,
  requestsMost,
  silence_ms,
  type LinkState,
  type Question,
  type SocketLike,
} from '../src/link/socket';

/** Virtual time: timers fire in order when advance() passes them. */
class World {
  now = 0;
  timers = new Map<number, { at: number; call: () => void }>();
  next = 1;
  sockets: FakeSocket[] = [];
  refuseOpen = false;
  host = {
    open: () => {
      if (this.refuseOpen) throw new Error('refused');
      const socket = new FakeSocket();
      this.sockets.push(socket);
      return socket;
    },
    now_ms: () => this.now,
    setTimer: (call: () => void, delay_ms: number) => {
      const id = this.next++;
      this.timers.set(id, { at: this.now + delay_ms, call });
      return id;
    },
    clearTimer: (id: number) => void this.timers.delete(id),
  };
  advance(ms: number): void {
    const end = this.now + ms;
    for (;;) {
      const due = [...this.timers].filter(([, timer]) => timer.at <= end).sort((a, b) => a[1].at - b[1].at || a[0] - b[0])[0];
      if (due === undefined) break;
      this.timers.delete(due[0]);
      this.now = due[1].at;
      due[1].call();
    }
    this.now = end;
  }
}
class FakeSocket implements SocketLike {
  binaryType = '';
  readyState = 0;
  bufferedAmount = 0;
  onopen: SocketLike['onopen'] = null;
  onclose: SocketLike['onclose'] = null;
  onmessage: SocketLike['onmessage'] = null;
  onerror: SocketLike['onerror'] = null;
  sent: Record<string, unknown>[] = [];
  closed = false;
  send(data: string) {
    this.sent.push(JSON.parse(data) as Record<string, unknown>);
  }
  close() {
    this.closed = true;
  }
  say(message: unknown) {
    this.onmessage?.({ data: typeof message === 'string' ? message : JSON.stringify(message) });
  }
}

let world: World;
let link: Link;
let states: LinkState[];
let texts: { type: string }[];
let refusedCount: number;
const last = () => world.sockets.at(-1)!;
const open = () => {
  last().onopen?.({});
  last().say({ type: 'welcome' });
};

beforeEach(() => {
  world = new World();
  states = [];
  texts = [];
  refusedCount = 0;
  link = new Link(world.host, {
    state: (state) => states.push(state),
    text: (message) => texts.push(message),
    binary: () => {},
    refused: () => refusedCount++,
  });
});

describe('reconnecting', () => {
  it('waits 0.25, 0.5, 1, 2, 2 … seconds between tries', () => {
    link.start();
    let wait = backOffFirst_ms;
    for (const expected of [250, 500, 1000, 2000, 2000]) {
      expect(wait).toBe(expected);
      const tries = world.sockets.length;
      last().onclose?.({ code: 1006, reason: '' });
      world.advance(wait - 1);
      expect(world.sockets).toHaveLength(tries);
      world.advance(1);
      expect(world.sockets).toHaveLength(tries + 1);
      wait = Math.min(backOffLast_ms, wait * 2);
    }
    expect(refusedCount).toBe(5);
  });

  it('starts with a short wait again only after a welcome, not after a mere handshake', () => {
    link.start();
    last().onopen?.({});
    last().onclose?.({ code: 1013, reason: '' });
    world.advance(250);
    last().onopen?.({});
    last().onclose?.({ code: 1013, reason: '' });
    world.advance(499);
    expect(world.sockets).toHaveLength(2);
    world.advance(1);
    open();
    last().onclose?.({ code: 1006, reason: '' });
    world.advance(250);
    expect(world.sockets).toHaveLength(4);
    expect(refusedCount).toBe(0);
  });

  it('tells open and lost once each', () => {
    link.start();
    open();
    last().onclose?.({ code: 1006, reason: '' });
    world.advance(250);
    open();
    expect(states).toEqual(['open', 'lost', 'open']);
  });

  it('gives up a connection that fell silent, and ignores what it says afterwards', () => {
    link.start();
    open();
    const dead = last();
    world.advance(silence_ms + 2 * ping_ms + backOffFirst_ms);
    expect(dead.closed).toBe(true);
    expect(states).toEqual(['open', 'lost']);
    expect(world.sockets.length).toBeGreaterThan(1);
    const before = texts.length;
    dead.say({ type: 'event' });
    dead.onclose?.({ code: 1006, reason: '' });
    expect(texts).toHaveLength(before);
  });

  /** Telemetry comes 5 times a second, and pings are answered, or not. */
  const listen = (for_ms: number, answered: boolean) => {
    for (const end = world.now + for_ms; world.now < end;) {
      const { sent } = last();
      const before = sent.length;
      world.advance(200);
      last().onmessage?.({ data: new ArrayBuffer(16) });
      if (answered) for (const { type, t } of sent.slice(before)) if (type === 'ping') last().say({ type: 'pong', t });
    }
  };

  it('stays open while it is heard and answers', () => {
    link.start();
    open();
    listen(10_000, true);
    expect(states).toEqual(['open']);
    expect(world.sockets).toHaveLength(1);
  });

  it('gives up a connection that is heard but does not answer, and says until then how long', () => {
    link.start();
    open();
    listen(5000, true);
    expect(link.rtt_s).toBe(0);
    listen(2000, false);
    expect(link.rtt_s).toBeCloseTo(1, 3);
    expect(states).toEqual(['open']);
    listen(silence_ms, false);
    expect(states.slice(0, 2)).toEqual(['open', 'lost']);
  });

  it('gives up a connection that never opens', () => {
    link.start();
    world.advance(10_000);
    expect(world.sockets.length).toBeGreaterThan(1);
  });

  it('tries again when the browser refuses to open a socket', () => {
    world.refuseOpen = true;
    link.start();
    world.advance(1000);
    world.refuseOpen = false;
    world.advance(2000);
    expect(world.sockets).toHaveLength(1);
  });

  it('hurries when asked, and never opens two at once', () => {
    link.start();
    last().onclose?.({ code: 1006, reason: '' });
    link.hurry();
    link.hurry();
    expect(world.sockets).toHaveLength(2);
    open();
    link.hurry();
    expect(world.sockets).toHaveLength(2);
  });

  it('does not come back after stop', () => {
    link.start();
    open();
    link.stop();
    world.advance(60_000);
    expect(world.sockets).toHaveLength(1);
    expect(world.timers.size).toBe(0);
  });
});

describe('requests', () => {
  beforeEach(() => {
    link.start();
    open();
  });

  it('match replies by number, in any order', async () => {
    const first = link.request({ type: 'neutral' });
    const second = link.request({ type: 'undo_settings' });
    const [a, b] = last().sent.filter((message) => 'request' in message);
    expect(a!.request).not.toBe(b!.request);
    last().say({ type: 'reply', request: b!.request, ok: true });
    last().say({ type: 'reply', request: a!.request, ok: false, refusals: ['moving'], errors: [] });
    expect((await second).ok).toBe(true);
    expect(await first).toMatchObject({ ok: false, refusals: ['moving'] });
  });

  it('ignore replies to unknown and already answered requests', async () => {
    const asked = link.request({ type: 'neutral' });
    const number = last().sent.find((message) => 'request' in message)!.request;
    last().say({ type: 'reply', request: 4711, ok: true });
    last().say({ type: 'reply', request: number, ok: true });
    last().say({ type: 'reply', request: number, ok: false });
    expect((await asked).ok).toBe(true);
  });

  it('take a broken reply as no', async () => {
    const asked = link.request({ type: 'neutral' });
    const number = last().sent.find((message) => 'request' in message)!.request;
    last().say({ type: 'reply', request: number, ok: 'yes', refusals: 'moving' });
    expect(await asked).toMatchObject({ ok: false, refusals: [], errors: [] });
  });

  it('end without an answer after two seconds', async () => {
    const asked = link.request({ type: 'neutral' });
    world.advance(replyWithin_ms);
    expect(await asked).toMatchObject({ ok: false, refusals: ['no_answer'] });
  });

  it('are taken back on the same connection when no answer comes, and again when they are done late', async () => {
    const end: Question = { type: 'mode', mode: 'standby' };
    const asked = link.request({ type: 'mode', mode: 'user' }, end);
    const number = last().sent.find((message) => message.mode === 'user')!.request;
    const ends = () => last().sent.filter((message) => message.mode === 'standby');
    world.advance(replyWithin_ms - 1);
    expect(ends()).toHaveLength(0);
    world.advance(1);
    expect(await asked).toMatchObject({ ok: false, refusals: ['no_answer'] });
    expect(ends()).toHaveLength(1);
    expect(ends()[0]!.request).not.toBe(number);
    last().say({ type: 'reply', request: number, ok: true });
    expect(ends()).toHaveLength(2);
    last().say({ type: 'reply', request: number, ok: true });
    expect(ends()).toHaveLength(2);
  });

  it('are taken back when a silent connection is given up, and not when they were answered', async () => {
    const end: Question = { type: 'mode', mode: 'standby' };
    const answered = link.request({ type: 'mode', mode: 'user' }, end);
    last().say({ type: 'reply', request: last().sent.at(-1)!.request, ok: true });
    expect((await answered).ok).toBe(true);
    const silent = last();
    world.advance(silence_ms);
    void link.request({ type: 'mode', mode: 'user' }, end);
    world.advance(2 * ping_ms);
    expect(silent.closed).toBe(true);
    expect(silent.sent.map((message) => message.mode ?? message.type).filter((what) => what !== 'ping')).toEqual(['user', 'user', 'standby']);
  });

  it('end when the connection is lost', async () => {
    const asked = link.request({ type: 'neutral' });
    last().onclose?.({ code: 1006, reason: '' });
    expect(await asked).toMatchObject({ ok: false, refusals: ['link_lost'] });
    expect(await link.request({ type: 'undo_settings' })).toMatchObject({ ok: false, refusals: ['link_lost'] });
    expect(link.send({ type: 'stop' })).toBe(false);
  });

  it('are bounded in number', async () => {
    for (let i = 0; i < requestsMost; i++) void link.request({ type: 'neutral' });
    const sent = last().sent.length;
    expect(await link.request({ type: 'neutral' })).toMatchObject({ ok: false });
    expect(last().sent).toHaveLength(sent);
  });

  it('survive damaged messages', () => {
    for (const message of ['', '{', 'null', '7', '[]', '{"type":7}']) last().say(message);
    expect(states).toEqual(['open']);
    expect(texts).toEqual([{ type: 'welcome' }]);
  });

  it('measure the round trip', () => {
    world.advance(ping_ms);
    const ping = last().sent.find((message) => message.type === 'ping')!;
    world.now += 37;
    last().say({ type: 'pong', t: ping.t });
    expect(link.rtt_s).toBeCloseTo(0.037, 9);
    world.now += 200;
    expect(link.rtt_s).toBeCloseTo(0.037, 9);
    last().onclose?.({ code: 1006, reason: '' });
    expect(link.rtt_s).toBeNull();
  });
});
