// The connection to the server: one WebSocket that reconnects, requests matched to their replies, and the measured round trip. Independent
// of screens. Clock, timers and socket are passed in, so that tests run it in virtual time.

import type { ClientMessage, ReplyMessage, ServerMessage } from '../contract/messages.gen';
import type { FieldError } from '../contract/rest.gen';

export type LinkState = 'connecting' | 'open' | 'lost';

export interface SocketLike {
  binaryType: string;
  readonly readyState: number;
  readonly bufferedAmount: number;
  onopen: ((event: unknown) => void) | null;
  onclose: ((event: { code: number; reason: string }) => void) | null;
  onmessage: ((event: { data: unknown }) => void) | null;
  onerror: ((event: unknown) => void) | null;
  send(data: string): void;
  close(code?: number, reason?: string): void;
}

export interface LinkHost {
  open(): SocketLike;
  now_ms(): number;
  setTimer(call: () => void, delay_ms: number): number;
  clearTimer(timer: number): void;
}

/** The server's answer, or why there is none: its lists are always there. */
export type Reply = Omit<ReplyMessage, 'type' | 'request' | 'refusals' | 'errors'> & { refusals: readonly string[]; errors: readonly FieldError[] };

type WithoutNumber<M> = M extends { request: number } ? Omit<M, 'request'> : never;
/** A message that is answered; the link gives it its number. */
export type Question = WithoutNumber<ClientMessage>;
/** What the page is told; replies and pongs are the link's own. */
export type Told = Exclude<ServerMessage, { type: 'reply' | 'pong' }>;

export interface LinkEvents {
  state(state: LinkState): void;
  text(message: Told): void;
  binary(buffer: ArrayBuffer): void;
  /** The socket was refused or broke before it opened; the page checks whether it is still signed in. */
  refused(): void;
}

export const subprotocol = 'hoist.v1';
export const backOffFirst_ms = 250;
export const backOffLast_ms = 2000;
/** Telemetry comes 5 times a second: silence this long, or no answer to a ping, means a dead connection, also while the socket says it is open. */
export const silence_ms = 2500;
export const openWithin_ms = 4000;
export const ping_ms = 1000;
export const replyWithin_ms = 2000;
/** Limit of pending requests; more means an endless loop. */
export const requestsMost = 64;

export const replyLost: Reply = { ok: false, refusals: ['link_lost'], errors: [] };

export class Link {
  private socket: SocketLike | null = null;
  private state_: LinkState = 'connecting';
  private backOff_ms = backOffFirst_ms;
  private retryTimer: number | null = null;
  private beatTimer: number | null = null;
  private heard_ms = 0;
  /** When the unanswered pings were sent, oldest first. */
  private pings: number[] = [];
  private answered_ms: number | null = null;
  private opened_ms = 0;
  private wasOpen = false;
  private stopped = false;
  private nextRequest = 1;
  private readonly waiting = new Map<number, { resolve: (reply: Reply) => void; timer: number; unanswered: Question | undefined }>();
  /** Timed-out requests, each with the request that revokes it. */
  private readonly late = new Map<number, Question>();

  constructor(
    private readonly host: LinkHost,
    private readonly events: LinkEvents,
  ) {}

  get state(): LinkState {
    return this.state_;
  }

  start(): void {
    this.stopped = false;
    this.connect();
  }

  /** Closes permanently. */
  stop(): void {
    this.stopped = true;
    if (this.retryTimer !== null) this.host.clearTimer(this.retryTimer);
    this.retryTimer = null;
    this.drop();
  }

  /** Tries again now, for example because the screen came back. */
  hurry(): void {
    if (this.stopped || this.socket !== null) return;
    if (this.retryTimer !== null) this.host.clearTimer(this.retryTimer);
    this.backOff_ms = backOffFirst_ms;
    this.connect();
  }

  /** Sends without waiting for an answer. False: not connected, nothing was sent. */
  send(message: ClientMessage): boolean {
    if (this.socket === null || this.state_ !== 'open') return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** The newest round trip; longer while an answer is overdue, since either direction may be dead. Null: none is known. */
  get rtt_s(): number | null {
    return this.answered_ms === null && this.pings.length === 0 ? null : Math.max(this.answered_ms ?? 0, this.unanswered_ms()) / 1000;
  }

  private unanswered_ms(): number {
    const now_ms = this.host.now_ms();
    return now_ms - (this.pings[0] ?? now_ms);
  }

  /** Bytes not yet sent by the browser: more than a few driving commands means a stalled link. */
  get queued(): number {
    return this.socket?.bufferedAmount ?? 0;
  }

  /** Sends a request and resolves with its reply; never rejects. A stalled connection may deliver a request long after the screen has reported a
   * failure: `unanswered` then follows on the same connection and revokes it. It is sent again when the late answer reports success, since a
   * server that needs several steps may have ended before it had begun. */
  request(message: Question, unanswered?: Question): Promise<Reply> {
    if (this.state_ !== 'open' || this.waiting.size >= requestsMost) return Promise.resolve(replyLost);
    const request = this.nextRequest++;
    return new Promise((resolve) => {
      const timer = this.host.setTimer(() => {
        this.waiting.delete(request);
        if (unanswered !== undefined) {
          this.late.set(request, unanswered);
          this.send({ ...unanswered, request: this.nextRequest++ });
        }
        resolve({ ok: false, refusals: ['no_answer'], errors: [] });
      }, replyWithin_ms);
      this.waiting.set(request, { resolve, timer, unanswered });
      if (!this.send({ ...message, request })) this.settle(request, replyLost);
    });
  }

  private settle(request: number, reply: Reply): void {
    const takeBack = this.late.get(request);
    this.late.delete(request);
    if (takeBack !== undefined && reply.ok) this.send({ ...takeBack, request: this.nextRequest++ });
    const entry = this.waiting.get(request);
    if (entry === undefined) return; // too late, or unknown
    this.waiting.delete(request);
    this.host.clearTimer(entry.timer);
    entry.resolve(reply);
  }

  private to(state: LinkState): void {
    if (this.state_ === state) return;
    this.state_ = state;
    this.events.state(state);
  }

  private connect(): void {
    this.retryTimer = null;
    let socket: SocketLike;
    try {
      socket = this.host.open();
    } catch {
      this.again();
      return;
    }
    this.socket = socket;
    this.opened_ms = this.host.now_ms();
    this.wasOpen = false;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      if (this.socket !== socket) return;
      this.wasOpen = true;
      this.heard_ms = this.host.now_ms();
      this.to('open');
    };
    socket.onmessage = (event) => {
      if (this.socket !== socket) return;
      this.heard_ms = this.host.now_ms();
      if (typeof event.data === 'string') this.readText(event.data);
      else if (event.data instanceof ArrayBuffer) this.events.binary(event.data);
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      const opened = this.wasOpen;
      this.drop();
      if (!opened) this.events.refused();
      this.again();
    };
    socket.onerror = () => {}; // a close always follows
    this.beatTimer ??= this.host.setTimer(() => this.beat(), ping_ms);
  }

  private readText(data: string): void {
    let message: unknown;
    try {
      message = JSON.parse(data);
    } catch {
      return; // a damaged message is no message
    }
    if (typeof message !== 'object' || message === null || typeof (message as { type?: unknown }).type !== 'string') return;
    const known = message as ServerMessage;
    if (known.type === 'reply') {
      // A broken reply is a no: nothing may look done that was not.
      const refusals = Array.isArray(known.refusals) ? known.refusals : [];
      this.settle(known.request, {
        ...known,
        ok: known.ok === true,
        refusals,
        errors: Array.isArray(known.errors) ? (known.errors as FieldError[]) : [],
      });
      return;
    }
    if (known.type === 'pong') {
      this.answered_ms = this.host.now_ms() - known.t;
      this.pings = this.pings.filter((sent_ms) => sent_ms > known.t);
      return;
    }
    // A welcome means that the server took us in: only then does the next loss start with a short wait again.
    if (known.type === 'welcome') this.backOff_ms = backOffFirst_ms;
    this.events.text(known);
  }

  private beat(): void {
    this.beatTimer = null;
    if (this.socket === null) return;
    const now_ms = this.host.now_ms();
    const dead = this.wasOpen ? Math.max(now_ms - this.heard_ms, this.unanswered_ms()) > silence_ms : now_ms - this.opened_ms > openWithin_ms;
    if (dead) {
      const socket = this.socket;
      this.drop();
      socket.close();
      this.again();
      return;
    }
    if (this.send({ type: 'ping', t: now_ms })) this.pings.push(now_ms);
    this.beatTimer = this.host.setTimer(() => this.beat(), ping_ms);
  }

  /** Drops the socket; pending requests fail. */
  private drop(): void {
    const socket = this.socket;
    this.socket = null;
    if (this.beatTimer !== null) this.host.clearTimer(this.beatTimer);
    this.beatTimer = null;
    // A connection closed by timeout could still deliver old messages; after close() nothing is sent or received.
    if (socket !== null && this.wasOpen)
      for (const { unanswered } of this.waiting.values())
        if (unanswered !== undefined) socket.send(JSON.stringify({ ...unanswered, request: this.nextRequest++ }));
    this.late.clear();
    if (socket !== null && this.stopped) socket.close();
    for (const request of [...this.waiting.keys()]) this.settle(request, replyLost);
    this.pings = [];
    this.answered_ms = null;
    this.to('lost');
  }

  private again(): void {
    if (this.stopped) return;
    this.retryTimer = this.host.setTimer(() => this.connect(), this.backOff_ms);
    this.backOff_ms = Math.min(backOffLast_ms, this.backOff_ms * 2);
  }
}
