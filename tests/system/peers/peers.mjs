// Our nodes and our SDO client against an independent CANopen stack (npm `canopen`, MIT), over the pipes of peers_bridge.
//   node peers.mjs BRIDGE SOURCE_DIR
// Waits end with their event; only the absence of an event gets a fixed time. Exits with 77 when the stack is not installed.
import { spawn } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

const [bridge, top] = process.argv.slice(2);
const report = /^xml:(.*\/)$/.exec(process.env.GTEST_OUTPUT ?? '')?.[1];
const escape = (text) => text.replace(/[<>&"]/g, (c) => `&#${c.charCodeAt(0)};`);
const writeReport = (body) => {
  if (report) writeFileSync(join(report, 'canopen_peers.xml'), `<testsuites><testsuite name="peers">${body}</testsuite></testsuites>\n`);
};

let canopen;
try {
  canopen = (await import('canopen')).default;
} catch (error) {
  const reason = `npm package canopen is not installed in tests/system/peers (npm ci): ${error.code ?? error.message}`;
  console.log(`skipped: ${reason}`);
  writeReport(`<testcase name="suite" classname="peers" result="skipped"><skipped message="peers.mjs:1&#x0A;${escape(reason)}"/></testcase>`);
  process.exit(77);
}
const { Device, Eds, DataType, NmtState } = canopen;

const patience_ms = 20000;
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const check = (fine, what) => {
  if (!fine) throw new Error(what);
};
const equal = (got, expected, what) => check(got === expected, `${what}: got ${got}, expected ${expected}`);
async function until(what, ask) {
  for (const end = Date.now() + patience_ms; Date.now() < end; await sleep(5)) {
    const value = await ask();
    if (value) return value;
  }
  throw new Error(`${what}: not within ${patience_ms / 1000} s`);
}

// A peers_bridge process, and every frame that it has sent.
class Bridge {
  frames = [];
  results = [];
  listeners = [];
  constructor(...words) {
    this.process = spawn(bridge, words, { stdio: ['pipe', 'pipe', 'inherit'] });
    this.process.stdin.on('error', () => {}); // it has ended; waiting cases fail with that
    createInterface({ input: this.process.stdout }).on('line', (text) => {
      const line = JSON.parse(text);
      if (line.result) this.results.push(line);
      else {
        const frame = { id: line.id, data: Buffer.from(line.data, 'hex') };
        this.frames.push(frame);
        for (const listener of this.listeners) listener(frame);
      }
    });
  }
  write(line) {
    if (this.process.stdin.writable) this.process.stdin.write(`${JSON.stringify(line)}\n`);
  }
  send(id, data) {
    this.write({ id, data: Buffer.from(data).toString('hex') });
  }
  // Connects a device of the peer: frames in both directions, as on a bus.
  couple(device) {
    device.addListener('message', ({ id, data }) => this.send(id, data));
    this.listeners.push(({ id, data }) => device.receive({ id, data, len: data.length }));
  }
  async result(what) {
    const before = this.results.length;
    this.write(what);
    return until(JSON.stringify(what), () => this.results[before]);
  }
  withId(id) {
    return this.frames.filter((frame) => frame.id === id);
  }
  async end() {
    this.process.stdin.end();
    await until('the end of the bridge', () => this.process.exitCode !== null);
    equal(this.process.exitCode, 0, 'exit code of the bridge');
  }
}

// The peer as master with the control computer's id, coupled to one of our nodes.
async function withNode(name, id, work) {
  const node = new Bridge('node', name);
  const master = new Device({ id: 0x7f, eds: new Eds() });
  try {
    master.eds.addSdoClientParameter(id, 0x600 + id, 0x580 + id);
    master.eds.addEmcyConsumer(0x80 + id);
    master.eds.addHeartbeatConsumer(id, 1000);
    const seen = { states: [], emergencies: [], timeouts: [] };
    master.nmt.on('heartbeat', ({ deviceId, state }) => seen.states.push([deviceId, state]));
    master.nmt.on('timeout', (deviceId) => seen.timeouts.push(deviceId));
    master.emcy.on('emergency', ({ cobId, em }) => seen.emergencies.push({ cobId, code: em.code, register: em.register }));
    await until('boot-up', () => node.withId(0x700 + id).some(({ data }) => data.length === 1 && data[0] === 0));
    node.couple(master);
    await work({ node, master, seen });
  } finally {
    master.stop();
    await node.end();
  }
}
const upload = (master, serverId, index, subIndex, dataType) => master.sdo.upload({ serverId, index, subIndex, dataType, timeout: 5000 });
const download = (master, serverId, index, subIndex, dataType, data) =>
  master.sdo.download({ serverId, index, subIndex, dataType, data, timeout: 5000 });
async function abortOf(promise) {
  try {
    await promise;
  } catch (error) {
    return error.code;
  }
  return 'no abort';
}

// The peer as slave with a small dictionary, read and written by our client.
async function withSlave(work) {
  const client = new Bridge('client');
  const slave = new Device({ id: 5, eds: new Eds() });
  try {
    slave.eds.addSdoServerParameter(5, 0x585, 0x605);
    slave.eds.addEntry(0x2000, { parameterName: 'text', dataType: DataType.VISIBLE_STRING, accessType: 'rw' });
    slave.eds.addEntry(0x2001, { parameterName: 'number', dataType: DataType.UNSIGNED32, accessType: 'rw' });
    slave.eds.addEntry(0x2002, { parameterName: 'fixed', dataType: DataType.UNSIGNED16, accessType: 'ro' });
    client.couple(slave);
    slave.start();
    await work({ client, slave });
  } finally {
    slave.stop();
    await client.end();
  }
}

const cases = {
  async 'our node boots up, beats and follows NMT commands'() {
    await withNode('drive_left', 1, async ({ node, master, seen }) => {
      master.start();
      await until('pre-operational', () => seen.states.some(([id, state]) => id === 1 && state === NmtState.PRE_OPERATIONAL));
      master.nmt.startNode(1);
      await until('operational', () => seen.states.some(([, state]) => state === NmtState.OPERATIONAL));
      master.nmt.stopNode(1);
      await until('stopped', () => seen.states.some(([, state]) => state === NmtState.STOPPED));
      const before = node.withId(0x701).filter(({ data }) => data[0] === 0).length;
      master.nmt.resetNode(1);
      await until('boot-up again', () => node.withId(0x701).filter(({ data }) => data[0] === 0).length > before);
    });
  },

  async 'the peer finds our node silent'() {
    await withNode('tilt_base', 0x13, async ({ node, master, seen }) => {
      master.start();
      await until('a heartbeat', () => seen.states.length > 0);
      equal(seen.timeouts.length, 0, 'time-outs while it beats');
      node.write({ set: 'silent', value: 1 });
      await until('the time-out', () => seen.timeouts.includes(0x13));
    });
  },

  async 'our drive misses the heartbeat of the peer, and says so'() {
    await withNode('drive_left', 1, async ({ node, master, seen }) => {
      master.eds.setHeartbeatProducerTime(50);
      master.start();
      await sleep(300); // some heartbeats of the peer
      master.nmt.startNode(1);
      await until('operational', () => seen.states.some(([, state]) => state === NmtState.OPERATIONAL));
      equal(seen.emergencies.length, 0, 'emergencies while the peer beats');
      master.eds.setHeartbeatProducerTime(0);
      await until('EMCY 8130h', () => seen.emergencies.some(({ cobId, code }) => cobId === 0x81 && code === 0x8130));
      await until('pre-operational again (1029h)', () => node.withId(0x701).at(-1)?.data[0] === 127);
    });
  },

  async 'expedited transfers of one, two and four bytes'() {
    await withNode('drive_left', 1, async ({ master }) => {
      master.start();
      equal(await upload(master, 1, 0x1000, 0, DataType.UNSIGNED32), 0x00020192, '1000h');
      equal(await upload(master, 1, 0x6061, 0, DataType.INTEGER8), 3, '6061h');
      await download(master, 1, 0x1017, 0, DataType.UNSIGNED16, 50);
      equal(await upload(master, 1, 0x1017, 0, DataType.UNSIGNED16), 50, '1017h');
      await download(master, 1, 0x2200, 1, DataType.REAL32, 0.5);
      equal(await upload(master, 1, 0x2200, 1, DataType.REAL32), 0.5, '2200h:1');
      await download(master, 1, 0x1029, 1, DataType.UNSIGNED8, 1);
      equal(await upload(master, 1, 0x1029, 1, DataType.UNSIGNED8), 1, '1029h:1');
    });
  },

  async 'segmented upload of the names'() {
    await withNode('io', 8, async ({ master }) => {
      master.start();
      equal(await upload(master, 8, 0x1008, 0, DataType.VISIBLE_STRING), 'Hoist input board', '1008h');
      const version = /project\(\w+ VERSION (\S+)/.exec(readFileSync(join(top, 'CMakeLists.txt'), 'utf8'))[1];
      equal(await upload(master, 8, 0x100a, 0, DataType.VISIBLE_STRING), version, '100Ah');
    });
  },

  async 'aborts with their codes'() {
    await withNode('drive_left', 1, async ({ master }) => {
      master.start();
      equal(await abortOf(upload(master, 1, 0x2fff, 0)), 0x06020000, 'no such object');
      equal(await abortOf(upload(master, 1, 0x2200, 99)), 0x06090011, 'no such sub-index');
      equal(await abortOf(download(master, 1, 0x1018, 1, DataType.UNSIGNED32, 1)), 0x06010002, 'read only');
      equal(await abortOf(download(master, 1, 0x1017, 0, DataType.UNSIGNED16, 5)), 0x06090030, 'out of range');
      equal(await abortOf(download(master, 1, 0x1017, 0, DataType.UNSIGNED8, 50)), 0x06070013, 'too short');
      equal(await abortOf(download(master, 1, 0x1017, 0, DataType.UNSIGNED32, 50)), 0x06070012, 'too long');
      equal(await abortOf(download(master, 1, 0x1017, 0, DataType.VISIBLE_STRING, 'ten letters')), 0x06070012, 'a text into a number');
      equal(await abortOf(master.sdo.upload({ serverId: 1, index: 0x1008, blockTransfer: true, timeout: 5000 })), 0x05040001, 'block transfer');
      equal(await upload(master, 1, 0x1017, 0, DataType.UNSIGNED16), 100, '1017h is as it was');
    });
  },

  async 'a synchronous PDO arrives with its values'() {
    await withNode('tilt_base', 0x13, async ({ node, master, seen }) => {
      const long = master.eds.addEntry(0x6010, { parameterName: 'slope long', dataType: DataType.INTEGER16 });
      const lateral = master.eds.addEntry(0x6020, { parameterName: 'slope lateral', dataType: DataType.INTEGER16 });
      const status = master.eds.addEntry(0x2120, { parameterName: 'status', dataType: DataType.UNSIGNED8 });
      const counter = master.eds.addEntry(0x2121, { parameterName: 'counter', dataType: DataType.UNSIGNED8 });
      master.eds.addReceivePdo({ cobId: 0x193, transmissionType: 1, dataObjects: [long, lateral, status, counter] });
      master.start();
      const received = [];
      master.pdo.on('pdo', ({ cobId }) => received.push([cobId, counter.value, status.value]));
      await until('pre-operational', () => seen.states.length > 0);
      node.send(0x080, []);
      await sleep(100);
      equal(node.withId(0x193).length, 0, 'PDOs before the start');
      master.nmt.startNode(0); // the master, too
      await until('operational', () => seen.states.some(([, state]) => state === NmtState.OPERATIONAL));
      for (let i = 0; i < 20; ++i) {
        const before = node.withId(0x193).length;
        node.send(0x080, []);
        await until('a PDO after the SYNC', () => node.withId(0x193).length > before);
      }
      await sleep(50);
      equal(node.withId(0x193).length, 20, 'PDOs of 20 SYNCs');
      check(received.length > 0 && received.every(([cobId]) => cobId === 0x193), 'the peer decoded none');
      // A computer that is upright and still: level, within a hundredth of a degree.
      check(Math.abs(long.value) <= 10 && Math.abs(lateral.value) <= 10, `level: ${long.value} ${lateral.value}`);
      equal(counter.value, node.withId(0x193).at(-1).data[5], 'sample counter');
    });
  },

  async 'a PDO on change, and what the peer may set before the start'() {
    await withNode('io', 8, async ({ node, master, seen }) => {
      master.start();
      await until('pre-operational', () => seen.states.length > 0);
      equal(await upload(master, 8, 0x1800, 1, DataType.UNSIGNED32), 0x40000188, '1800h:1');
      equal(await upload(master, 8, 0x1a00, 1, DataType.UNSIGNED32), 0x60000108, '1A00h:1');
      await download(master, 8, 0x1800, 1, DataType.UNSIGNED32, 0x400001aa);
      await download(master, 8, 0x1800, 5, DataType.UNSIGNED16, 0);
      master.nmt.startNode(8);
      await until('operational', () => seen.states.some(([, state]) => state === NmtState.OPERATIONAL));
      node.write({ set: 'bumpers', value: 5 });
      await until('the PDO with the new id', () => node.withId(0x1aa).some(({ data }) => data[0] === 5));
      equal(node.withId(0x188).length, 0, 'PDOs with the old id');
      equal(await abortOf(download(master, 8, 0x1800, 1, DataType.UNSIGNED32, 0x40000188)), 0x08000022, 'setting it under way');
    });
  },

  async 'EMCY comes, is remembered and forgotten'() {
    await withNode('drive_left', 1, async ({ node, master, seen }) => {
      master.start();
      await until('pre-operational', () => seen.states.length > 0);
      master.nmt.startNode(1);
      await until('operational', () => seen.states.some(([, state]) => state === NmtState.OPERATIONAL));
      node.send(0x201, [6, 0, 0]); // too short a command
      await until('EMCY 8210h', () => seen.emergencies.some(({ code, register }) => code === 0x8210 && (register & 0x11) === 0x11));
      equal(await upload(master, 1, 0x1003, 0, DataType.UNSIGNED8), 1, 'errors remembered');
      equal((await upload(master, 1, 0x1003, 1, DataType.UNSIGNED32)) & 0xffff, 0x8210, 'the error');
      await download(master, 1, 0x1003, 0, DataType.UNSIGNED8, 0);
      equal(await upload(master, 1, 0x1003, 0, DataType.UNSIGNED8), 0, 'errors after forgetting');
    });
  },

  async 'parameters are saved and come back after a reset'() {
    await withNode('drive_right', 2, async ({ node, master, seen }) => {
      master.start();
      await until('pre-operational', () => seen.states.length > 0);
      await download(master, 2, 0x6085, 0, DataType.UNSIGNED32, 250);
      equal(await abortOf(download(master, 2, 0x1010, 1, DataType.UNSIGNED32, 1)), 0x08000020, 'a wrong word');
      await download(master, 2, 0x1010, 1, DataType.UNSIGNED32, 0x65766173);
      const boots = () => node.withId(0x702).filter(({ data }) => data[0] === 0).length;
      const before = boots();
      master.nmt.resetNode(2);
      await until('boot-up', () => boots() > before);
      equal(await upload(master, 2, 0x6085, 0, DataType.UNSIGNED32), 250, '6085h');
    });
  },

  async 'the EDS of every node is read by the peer'() {
    for (const name of ['drive_left', 'drive_right', 'io', 'tilt_left', 'tilt_right', 'tilt_base']) {
      const eds = Eds.fromFile(join(top, `firmware/nodes/eds/${name}.gen.eds`));
      const id = eds.getEntry(0x1014).value & 0x7f;
      equal(eds.getSubEntry(0x1200, 1).value, 0x600 + id, `${name} 1200h:1`);
      check(eds.getEntry(0x1008) !== undefined, `${name} has 1008h`);
      const pdos = eds.getTransmitPdos();
      check(pdos.some(({ cobId, dataObjects }) => cobId === 0x180 + id && dataObjects.length >= 2), `${name} TPDO1`);
    }
  },

  async 'our client reads and writes the peer, expedited and segmented'() {
    await withSlave(async ({ client, slave }) => {
      const text = 'segments of seven bytes each, and a rest';
      let done = await client.result({ download: [5, 0x2000, 0], data: Buffer.from(text).toString('hex') });
      equal(done.result, 'done', 'segmented download');
      equal(slave.getValue(0x2000), text, 'the text at the peer');
      done = await client.result({ upload: [5, 0x2000, 0] });
      equal(done.result, 'done', 'segmented upload');
      equal(Buffer.from(done.data, 'hex').toString(), text, 'the text back');
      done = await client.result({ download: [5, 0x2001, 0], data: '78563412' });
      equal(done.result, 'done', 'expedited download');
      equal(slave.getValue(0x2001), 0x12345678, 'the number at the peer');
      done = await client.result({ upload: [5, 0x2001, 0] });
      equal(done.data, '78563412', 'the number back');
    });
  },

  async 'our client understands the refusals of the peer'() {
    await withSlave(async ({ client }) => {
      let done = await client.result({ upload: [5, 0x3333, 0] });
      equal(done.result, 'aborted', 'no such object');
      equal(done.code, 0x06020000, 'its code');
      done = await client.result({ download: [5, 0x2002, 0], data: '0100' });
      equal(done.result, 'aborted', 'read only');
      equal(done.code, 0x06010002, 'its code');
      done = await client.result({ upload: [6, 0x2001, 0] });
      equal(done.result, 'timed_out', 'nobody there');
      done = await client.result({ upload: [5, 0x1000, 0] });
      equal(done.result, 'done', 'and goes on afterwards');
    });
  },

  async 'a toggle bit that does not change ends a transfer of our node'() {
    const node = new Bridge('node', 'tilt_left');
    try {
      await until('boot-up', () => node.withId(0x711).length > 0);
      const ask = async (bytes) => {
        const before = node.withId(0x591).length;
        node.send(0x611, bytes);
        return until('an answer', () => node.withId(0x591)[before]?.data);
      };
      equal((await ask([0x40, 0x08, 0x10, 0, 0, 0, 0, 0]))[0], 0x41, 'begun');
      equal((await ask([0x60, 0, 0, 0, 0, 0, 0, 0]))[0] & 0x10, 0, 'first segment');
      const abort = await ask([0x60, 0, 0, 0, 0, 0, 0, 0]);
      equal(abort[0], 0x80, 'abort');
      equal(abort.readUInt32LE(4), 0x05030000, 'its code');
    } finally {
      await node.end();
    }
  },
};

let failed = 0;
let body = '';
for (const [name, work] of Object.entries(cases)) {
  let problem = '';
  try {
    await work();
  } catch (error) {
    problem = error.stack ?? String(error);
    ++failed;
  }
  console.log(`${problem ? 'FAILED' : 'ok    '} ${name}${problem ? `\n${problem}` : ''}`);
  body += `<testcase name="${escape(name)}" classname="peers">${problem ? `<failure message="${escape(problem)}"/>` : ''}</testcase>`;
}
writeReport(body);
process.exit(failed ? 1 : 0);
