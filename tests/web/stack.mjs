// The real programs for the browser tests: simulator, control core and server in their own folder, and queries to them.
import { spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { connect, createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Polls until `check` gives a result; on timeout it names what was awaited. The limit is long, for busy computers. Where the time itself is
 * tested, the caller gives it. */
export async function until(what, check, within_ms = 15_000, each_ms = 40) {
  const end = performance.now() + within_ms;
  for (;;) {
    const value = await check();
    if (value) return value;
    if (performance.now() > end) throw new Error(`${what}: not within ${within_ms} ms`);
    await sleep(each_ms);
  }
}

export function assert(condition, message) {
  if (!condition) throw new Error(message);
}

const freePort = () =>
  new Promise((resolve, reject) => {
    const probe = createServer();
    probe.on('error', reject);
    probe.listen(0, '127.0.0.1', () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });

const startsWithin_ms = 30_000;
const lastLines = 25;
class Program {
  constructor(name, file, args) {
    this.name = name;
    this.output = '';
    this.ended = false;
    this.child = spawn(file, args, { stdio: ['ignore', 'pipe', 'pipe'] });
    for (const stream of [this.child.stdout, this.child.stderr]) stream.on('data', (data) => (this.output = (this.output + data).slice(-20_000)));
    this.exit = new Promise((resolve) => this.child.on('exit', (code, signal) => resolve((this.ended = true) && { code, signal })));
  }
  tail() {
    return this.output.split('\n').slice(-lastLines).join('\n');
  }
  async kill(signal) {
    if (!this.ended) this.child.kill(signal);
    await Promise.race([this.exit, sleep(5000)]);
    if (!this.ended) this.child.kill('SIGKILL');
    await this.exit;
  }
}

export class Stack {
  constructor({ bin, web, scenario = 'figure-eight' }) {
    Object.assign(this, { bin, web, scenario });
    this.folder = mkdtempSync(join(tmpdir(), 'hoist-e2e-'));
    for (const name of ['data', 'backups']) mkdirSync(join(this.folder, name));
    this.programs = {};
  }
  path(...parts) {
    return join(this.folder, ...parts);
  }
  run(name, args) {
    this.programs[name] = new Program(name, join(this.bin, name), args);
    return this.programs[name];
  }
  /** Waits as long as a program can take to start, unless it has ended. */
  ready(program, what, check) {
    return until(
      `${program.name} ${what}`,
      () => {
        assert(!program.ended, `${program.name} ended instead of starting`);
        return check();
      },
      startsWithin_ms,
    );
  }
  async startSim() {
    // What a killed one left behind is not the new one's.
    for (const left of ['step.sock', 'sim.sock']) rmSync(this.path(left), { force: true });
    const sim = this.run('hoist-sim', ['--scenario', this.scenario, '--lock-step', this.path('step.sock'), '--control', this.path('sim.sock')]);
    await this.ready(sim, 'makes its bus', () => existsSync(this.path('step.sock')) && existsSync(this.path('sim.sock')));
  }
  async startControl() {
    rmSync(this.path('core.sock'), { force: true });
    const control = this.run('hoist-control', ['--bus', `sim:${this.path('step.sock')}`, '--socket', this.path('core.sock'), '--params', this.path('data', 'parameters.json')]);
    await this.ready(control, 'makes its socket', () => existsSync(this.path('core.sock')));
  }
  async startServer() {
    this.port ??= await freePort();
    const server = this.run('hoist-server', ['--socket', this.path('core.sock'), '--port', String(this.port), '--web', this.web, '--db', this.path('data', 'hoist.db'),
      '--scenario', this.scenario, '--token-file', this.path('token'), '--backup-root', this.path('backups')]);
    this.link = await this.ready(server, 'prints its link', () => /Open (http:\S+)/.exec(server.output)?.[1]);
    this.origin = new URL(this.link).origin;
  }
  async start() {
    await this.startSim();
    await this.startControl();
    await this.startServer();
  }

  /** A fresh one-time link: the newest that the server printed. */
  newestLink() {
    return [...this.programs['hoist-server'].output.matchAll(/(http:\/\/\S+\?token=\S+)/g)].at(-1)[1];
  }

  /** The browser, at low priority: software rendering would otherwise slow the hoist's time. */
  politely(program) {
    const wrapper = this.path('browser');
    writeFileSync(wrapper, `#!/bin/sh\nexec nice -n 10 "${program}" "$@"\n`, { mode: 0o700 });
    return wrapper;
  }

  /** Queries the simulator's true state over its own socket. */
  ask(request) {
    return new Promise((resolve, reject) => {
      const socket = connect(this.path('sim.sock'));
      let text = '';
      socket.setTimeout(3000, () => socket.destroy(new Error('hoist-sim does not answer')));
      socket.on('error', reject);
      socket.on('connect', () => socket.write(`${JSON.stringify(request)}\n`));
      socket.on('data', (data) => {
        text += data;
        if (!text.includes('\n')) return;
        socket.end();
        const answer = JSON.parse(text.split('\n')[0]);
        if (answer.error) reject(new Error(`hoist-sim: ${answer.error}`));
        else resolve(answer);
      });
    });
  }
  truth() {
    return this.ask({ op: 'state' });
  }

  /** A request with the token for scripts. */
  async rest(method, path, body) {
    const response = await fetch(`${this.origin}/api/v1${path}`, {
      method,
      headers: {
        Authorization: `Bearer ${readFileSync(this.path('token'), 'utf8').trim()}`,
        ...(['PUT', 'PATCH', 'DELETE'].includes(method) ? { 'If-Match': '*' } : {}),
        ...(body === undefined ? {} : { 'Content-Type': 'application/json' }),
      },
      body: body === undefined ? undefined : JSON.stringify(body),
    });
    const text = await response.text();
    return { status: response.status, text, json: () => JSON.parse(text) };
  }

  /** The server's state of the control core. */
  async coreStatus() {
    return (await this.rest('GET', '/status')).json().core;
  }

  async stop() {
    for (const name of ['hoist-server', 'hoist-control', 'hoist-sim']) await this.programs[name]?.kill('SIGTERM');
    rmSync(this.folder, { recursive: true, force: true });
  }
  outputs() {
    return Object.values(this.programs)
      .map((program) => `--- ${program.name}${program.ended ? ' (ended)' : ''}\n${program.tail()}`)
      .join('\n');
  }
}
