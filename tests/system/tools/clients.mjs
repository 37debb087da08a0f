// clients.mjs PORT TOKEN CASE: one case of tests/system/tool_clients.py, with third-party clients:
// @foxglove/ws-protocol and roslib.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import protocol from "@foxglove/ws-protocol";
import { McapIndexedReader } from "@mcap/core";
import * as ROSLIB from "roslib";
import WebSocket from "ws";

const [port, token, wanted] = process.argv.slice(2);
const address = (path) => `ws://127.0.0.1:${port}${path}?token=${token}`;
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

async function until(what, ask, within_ms = 15000) {
  const end = Date.now() + within_ms;
  for (;;) {
    const value = ask();
    if (value !== undefined && value !== false) return value;
    if (Date.now() > end) assert.fail(`${what}: not within ${within_ms} ms`);
    await sleep(10);
  }
}

// A Foxglove client that collects what comes.
class Foxglove {
  constructor(subprotocol) {
    this.socket = new WebSocket(address("/foxglove"), subprotocol);
    this.client = new protocol.FoxgloveClient({ ws: this.socket });
    this.channels = new Map();
    this.services = new Map();
    this.messages = new Map();
    this.parameters = new Map();
    this.answers = new Map();
    this.statuses = [];
    this.subscriptions = new Map();
    this.calls = 0;
    this.client.on("error", (error) => this.statuses.push(String(error)));
    this.client.on("serverInfo", (info) => (this.info = info));
    this.client.on("status", (status) => this.statuses.push(status.message));
    this.client.on("advertise", (list) => list.forEach((c) => this.channels.set(c.topic, c)));
    this.client.on("advertiseServices", (list) => list.forEach((s) => this.services.set(s.name, s)));
    this.client.on("parameterValues", ({ parameters, id }) => {
      parameters.forEach((p) => this.parameters.set(p.name, p.value));
      if (id !== undefined) this.answers.set(id, parameters);
    });
    this.client.on("serviceCallResponse", (answer) => this.answers.set(answer.callId, answer));
    this.client.on("message", ({ subscriptionId, timestamp, data }) => {
      const seen = this.subscriptions.get(subscriptionId);
      const text = () => JSON.parse(new TextDecoder().decode(data));
      const value = seen.reader ? seen.reader.readMessage(data) : text();
      seen.list.push(seen.plain ? value : { time_ns: timestamp, value });
    });
  }
  async ready() {
    await until("services", () => this.services.size > 0);
    return this;
  }
  watch(topic, plain = false) {
    const channel = this.channels.get(topic);
    assert.ok(channel, `no topic ${topic}`);
    const reader = channel.encoding === "cdr" ? new MessageReader(parse(channel.schema, { ros2: true })) : undefined;
    const list = [];
    this.subscriptions.set(this.client.subscribe(channel.id), { list, reader, plain });
    return list;
  }
  async call(name, encoding = "json") {
    const callId = ++this.calls;
    const empty = encoding === "json" ? new TextEncoder().encode("{}") : new Uint8Array([0, 1, 0, 0, 0]);
    this.client.sendServiceCallRequest({ serviceId: this.services.get(name).id, callId, encoding, data: new DataView(empty.buffer) });
    const answer = await until(`${name} answers`, () => this.answers.get(callId));
    assert.equal(answer.encoding, encoding);
    if (encoding === "json") return JSON.parse(new TextDecoder().decode(answer.data));
    return new MessageReader(parse("bool success\nstring message\n", { ros2: true })).readMessage(answer.data);
  }
  async set(name, value) {
    const id = `set-${++this.calls}`;
    this.client.setParameters([{ name, value, type: "float64" }], id);
    return (await until("parameterValues", () => this.answers.get(id)))[0].value;
  }
  teleop() {
    const channel = this.client.advertise({ topic: "/cmd_vel", encoding: "json", schemaName: "geometry_msgs/Twist" });
    return (x, z) => {
      const twist = { linear: { x, y: 0, z: 0 }, angular: { x: 0, y: 0, z } };
      this.client.sendMessage(channel, new TextEncoder().encode(JSON.stringify(twist)));
    };
  }
  close() {
    this.client.close();
  }
}

// What both protocols must do with a hand on a button: drive, stop when it falls silent, drive again, be capped, STOP. `intents`: the messages of
// /hoist/intent so far. Commands are judged, since the simulated machine stumbles when its computer is busy.
async function drives({ send, call, intents, mode }) {
  const command = () => intents.at(-1).speed_command_m_s;
  const hold = async (what, x, done, most_s = 15) => {
    for (const end = Date.now() + most_s * 1000; Date.now() < end; await sleep(100)) {
      send(x, 0);
      if (done()) return;
    }
    assert.fail(`${what}: not within ${most_s} s; ${mode()}, ${command()} m/s`);
  };
  let count = 0;
  await hold("a tool without control", 0.2, () => ++count > 5);
  assert.ok(intents.every((i) => i.speed_command_m_s === 0), "a tool without control moves the hoist");
  assert.equal((await call("/hoist/take_control")).success, true);
  const begun = await call("/hoist/drive");
  assert.ok(begun.success, begun.message);
  await until("REMOTE", () => mode() === "remote");
  await sleep(500); // after 0.2 s of silence the core is told that the button is released
  await hold("it drives", 0.2, () => command() > 0.15);
  // The button is released: a tool sends nothing more.
  await until("the hoist stands", () => Math.abs(command()) < 0.005, 5000);
  assert.equal(mode(), "remote");
  await sleep(500);
  const from = intents.length;
  await hold("it drives again", 5, () => command() > 0.19);
  count = 0;
  await hold("it goes on", 5, () => ++count > 10);
  const most = Math.max(...intents.slice(from).map((i) => i.speed_command_m_s));
  assert.ok(most > 0.19 && most < 0.201, `asked for 5 m/s, cut to ${most} m/s`);
  assert.equal((await call("/hoist/stop")).success, true);
  await hold("STOP holds although the button is held", 0.2, () => mode() !== "remote" && command() === 0);
  await call("/hoist/release_control");
}

// A program of @foxglove/ws-protocol-examples, as published; what it prints is in `text`.
function example(...args) {
  const index = new URL("node_modules/@foxglove/ws-protocol-examples/dist/cjs/ws-protocol-examples/src/index.js", import.meta.url);
  const program = spawn(process.execPath, [fileURLToPath(index), ...args], { stdio: ["ignore", "pipe", "pipe"] });
  program.text = "";
  for (const stream of [program.stdout, program.stderr]) stream.on("data", (data) => (program.text += data));
  return program;
}

const cases = {
  async foxglove_examples() {
    const folder = mkdtempSync(join(tmpdir(), "hoist-mcap-"));
    const file = join(folder, "live.mcap");
    const recorder = example("mcap-record", address("/foxglove"), "--output", file, "--no-compression");
    const simple = example("simple-client", address("/foxglove"));
    try {
      await until("mcap-record subscribes", () => recorder.text.match(/subscribing to/gu)?.length === 13, 60000);
      // It tells no message; what another client has seen since, it has seen, too.
      const beside = await new Foxglove("foxglove.websocket.v1").ready();
      const lists = [...beside.channels.keys()].map((topic) => beside.watch(topic, true));
      await until("every topic speaks", () => lists.every((list) => list.length > 3), 60000);
      beside.close();
      await until("simple-client shows a value", () => /lean_norm: -?[\d.]/u.test(simple.text), 60000);
      assert.equal(simple.exitCode, null, simple.text);
      recorder.kill("SIGINT");
      const [code] = await once(recorder, "exit");
      assert.equal(code, 0, recorder.text);
      const bytes = readFileSync(file);
      const readable = {
        size: async () => BigInt(bytes.length),
        read: async (at, size) => new Uint8Array(bytes.subarray(Number(at), Number(at + size))),
      };
      const reader = await McapIndexedReader.Initialize({ readable });
      assert.equal(reader.channelsById.size, 13);
      const decoders = new Map();
      for (const [id, { schemaId, messageEncoding }] of reader.channelsById) {
        const { data, encoding } = reader.schemasById.get(schemaId);
        const schema = new TextDecoder().decode(data);
        assert.equal(encoding, messageEncoding === "cdr" ? "ros2msg" : "jsonschema");
        const cdr = messageEncoding === "cdr" ? new MessageReader(parse(schema, { ros2: true })) : null;
        decoders.set(id, cdr ? (message) => cdr.readMessage(message) : (message) => JSON.parse(new TextDecoder().decode(message)));
      }
      const newest = new Map();
      for await (const { channelId, data } of reader.readMessages())
        newest.set(reader.channelsById.get(channelId).topic, decoders.get(channelId)(data));
      assert.equal(newest.size, 13, "a topic was not recorded");
      assert.equal(newest.get("/odom").child_frame_id, "base_link");
      assert.ok(Number.isFinite(newest.get("/hoist/intent").lean_norm));
    } finally {
      recorder.kill("SIGKILL");
      simple.kill("SIGKILL");
      rmSync(folder, { recursive: true });
    }
  },
  async foxglove_topics() {
    for (const subprotocol of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) {
      const tool = await new Foxglove([subprotocol, "something.else"]).ready().catch((error) => assert.fail(`${subprotocol}: ${error}`));
      assert.equal(tool.socket.protocol, subprotocol);
      assert.ok(tool.info.capabilities.includes("clientPublish"));
      assert.equal(tool.channels.size, 13);
      // Studio reads these in the first encoding that the server names.
      assert.equal(tool.info.supportedEncodings[0], "json");
      for (const service of tool.services.values()) for (const schema of ["requestSchema", "responseSchema"]) JSON.parse(service[schema]);
      const lists = new Map([...tool.channels.keys()].map((topic) => [topic, tool.watch(topic)]));
      await until("every topic speaks", () => [...lists.values()].every((list) => list.length > 3), 20000);
      const begin = new Map([...lists].map(([topic, list]) => [topic, list.length]));
      await sleep(1000);
      for (const [topic, list] of lists) {
        const times = list.map((m) => m.time_ns);
        assert.ok(times.every((t, i) => i === 0 || t > times[i - 1]), `${topic}: time runs backwards`);
        assert.ok(list.length - begin.get(topic) <= 60, `${topic}: ${list.length - begin.get(topic)} in a second`);
        const newest = Number(times.at(-1) / 1000000n);
        assert.ok(Math.abs(newest - Date.now()) < 5000, `${topic}: ${newest - Date.now()} ms from now`);
      }
      const odom = lists.get("/odom").at(-1).value;
      assert.equal(odom.child_frame_id, "base_link");
      const transforms = lists.get("/tf").at(-1).value.transforms.map((t) => t.child_frame_id);
      assert.deepEqual(transforms, ["base_link", "strut_left", "strut_right", "chassis"]);
      assert.deepEqual(lists.get("/scene").at(-1).value.entities.map((e) => e.id), ["chassis", "strut_left", "strut_right", "mode"]);
      assert.ok(lists.get("/path").at(-1).value.poses.length >= 1);
      assert.ok(Number.isFinite(lists.get("/hoist/intent").at(-1).value.lean_norm));
      tool.close();
    }
  },
  async foxglove_parameters() {
    const tool = await new Foxglove("foxglove.websocket.v1").ready();
    const other = await new Foxglove("foxglove.sdk.v1").ready();
    other.client.subscribeParameterUpdates(["remote_speed_m_s_max"]);
    tool.client.getParameters([], "all");
    await until("all parameters", () => tool.answers.get("all")?.length > 50);
    assert.ok(tool.answers.get("all").every((p) => p.type === "float64"));
    assert.equal(await tool.set("remote_speed_m_s_max", 0.25), 0.25);
    await until("the other tool sees it", () => other.parameters.get("remote_speed_m_s_max") === 0.25);
    assert.equal(await tool.set("remote_speed_m_s_max", 9), 0.25); // refused: the answer carries what is in force
    await until("the reason", () => tool.statuses.some((text) => /remote_speed_m_s_max/u.test(text)));
    // A client that has not been shown the newest values is refused (H27).
    tool.client.getParameters([], "again");
    await until("again", () => tool.answers.get("again"));
    other.client.getParameters(["remote_speed_m_s_max"], "seen");
    await until("seen", () => other.answers.get("seen"));
    assert.equal(await other.set("remote_speed_m_s_max", 0.3), 0.3);
    assert.equal(await tool.set("remote_speed_m_s_max", 0.25), 0.3);
    await until("the reason", () => tool.statuses.some((text) => /stale_version|changed/iu.test(text)));
    tool.close();
    other.close();
  },
  async foxglove_drives() {
    const tool = await new Foxglove("foxglove.sdk.v1").ready();
    const intents = tool.watch("/hoist/intent", true);
    const diagnostics = tool.watch("/diagnostics", true);
    await until("values", () => intents.length > 0 && diagnostics.length > 0);
    await drives({
      send: tool.teleop(),
      call: (name) => tool.call(name, name === "/hoist/drive" ? "cdr" : "json"),
      intents,
      mode: () => diagnostics.at(-1).status[0].values.find((v) => v.key === "mode").value,
    });
    tool.close();
  },
  async rosbridge_reads() {
    const ros = new ROSLIB.Ros({ url: address("/rosbridge") });
    await new Promise((open, fail) => (ros.on("connection", open), ros.on("error", fail)));
    const topics = await new Promise((done, fail) => ros.getTopics(done, fail));
    assert.equal(topics.topics.length, 13);
    assert.equal(topics.types[topics.topics.indexOf("/odom")], "nav_msgs/Odometry");
    const seen = new Map();
    for (const [i, name] of topics.topics.entries()) {
      seen.set(name, 0);
      new ROSLIB.Topic({ ros, name, messageType: topics.types[i] }).subscribe(() => seen.set(name, seen.get(name) + 1));
    }
    await until("every topic speaks", () => [...seen.values()].every((count) => count > 2), 20000);
    // Values of a slow subscription.
    ros.close();
    const slow = new ROSLIB.Ros({ url: address("/rosbridge") });
    await new Promise((open, fail) => (slow.on("connection", open), slow.on("error", fail)));
    let count = 0;
    new ROSLIB.Topic({ ros: slow, name: "/odom", messageType: "nav_msgs/Odometry", throttle_rate: 200 }).subscribe(() => ++count);
    await until("the first", () => count > 0);
    count = 0;
    await sleep(1000);
    assert.ok(count >= 3 && count <= 6, `${count} messages in a second with 200 ms between them`);
    const names = await new Promise((done, fail) => slow.getParams(done, fail));
    assert.ok(names.includes("remote_speed_m_s_max"));
    const parameter = new ROSLIB.Param({ ros: slow, name: "remote_speed_m_s_max" });
    const read = () => new Promise((done, fail) => parameter.get(done, fail));
    const write = (value) => new Promise((done, fail) => parameter.set(value, done, fail));
    await read();
    await write(0.28);
    assert.equal(await read(), 0.28);
    await write(7).catch(() => undefined);
    assert.equal(await read(), 0.28);
    await write(0.3);
    slow.close();
  },
  async rosbridge_drives() {
    const ros = new ROSLIB.Ros({ url: address("/rosbridge") });
    await new Promise((open, fail) => (ros.on("connection", open), ros.on("error", fail)));
    const intents = [];
    let diagnostics;
    new ROSLIB.Topic({ ros, name: "/hoist/intent", messageType: "hoist.Intent" }).subscribe((m) => intents.push(m));
    new ROSLIB.Topic({ ros, name: "/diagnostics", messageType: "diagnostic_msgs/DiagnosticArray" }).subscribe((m) => (diagnostics = m));
    await until("values", () => intents.length > 0 && diagnostics);
    const cmd = new ROSLIB.Topic({ ros, name: "/cmd_vel", messageType: "geometry_msgs/Twist" });
    await drives({
      send: (x, z) => cmd.publish({ linear: { x, y: 0, z: 0 }, angular: { x: 0, y: 0, z } }),
      call: (name) =>
        new Promise((done, fail) => new ROSLIB.Service({ ros, name, serviceType: "std_srvs/Trigger" }).callService({}, done, fail)),
      intents,
      mode: () => diagnostics.status[0].values.find((v) => v.key === "mode").value,
    });
    ros.close();
  },
};

try {
  await cases[wanted]();
  process.exit(0);
} catch (error) {
  console.error(error);
  process.exit(1);
}
