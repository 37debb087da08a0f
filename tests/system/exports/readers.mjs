// Our exports read by third-party programs: @mcap/core, @foxglove/rosmsg2-serialization, mat-for-js, and matdump of
// libmatio.
//   node readers.mjs MAKE_RECORDING HOIST
// Every number must equal that of the CSV. Exits with 77 when the npm packages are not installed.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const [makeRecording, hoist] = process.argv.slice(2);
const report = /^xml:(.*\/)$/.exec(process.env.GTEST_OUTPUT ?? '')?.[1];
const escape = (text) => text.replace(/[<>&"\n]/g, (c) => `&#${c.charCodeAt(0)};`);
const writeReport = (body) => {
  if (report) writeFileSync(join(report, 'export_readers.xml'), `<testsuites><testsuite name="export_readers">${body}</testsuite></testsuites>\n`);
};

let mcap, rosmsg, serialization, zstd, mat;
try {
  mcap = await import('@mcap/core');
  rosmsg = await import('@foxglove/rosmsg');
  serialization = await import('@foxglove/rosmsg2-serialization');
  mat = await import('mat-for-js');
  zstd = (await import('@foxglove/wasm-zstd')).default;
  await zstd.isLoaded;
} catch (error) {
  const reason = `npm packages are not installed in tests/system/exports (npm ci): ${error.code ?? error.message}`;
  console.log(`skipped: ${reason}`);
  writeReport(`<testcase name="suite" classname="export_readers" result="skipped"><skipped message="readers.mjs:1&#x0A;${escape(reason)}"/></testcase>`);
  process.exit(77);
}

const check = (fine, what) => {
  if (!fine) throw new Error(what);
};
const equal = (got, expected, what) => check(Object.is(got, expected) || got === expected, `${what}: got ${got}, expected ${expected}`);

const folder = mkdtempSync(join(tmpdir(), 'hoist-exports-'));
const database = join(folder, 'hoist.db');
execFileSync(makeRecording, [database]);
function exported(format, ...options) {
  const file = join(folder, `out.${format}`);
  execFileSync(hoist, ['export', database, '1', '--format', format, '--out', file, ...options]);
  return file;
}
// Every line of this CSV is plain numbers, but for utc.
const [names, ...rows] = readFileSync(exported('csv', '--no-comments'), 'utf8').trimEnd().split('\n').map((line) => line.split(','));
const column = Object.fromEntries(names.map((name, i) => [name, i]));
const number = (row, name) => Number(rows[row][column[name]]);

const decompressHandlers = { zstd: (buffer, size) => new Uint8Array(zstd.decompress(buffer, Number(size))) };
class BytesReadable {
  constructor(bytes) {
    this.bytes = bytes;
    this.asked = 0;
  }
  async size() {
    return BigInt(this.bytes.length);
  }
  async read(offset, length) {
    this.asked += Number(length);
    return new Uint8Array(this.bytes.subarray(Number(offset), Number(offset + length)));
  }
}

// What an indexed reader finds, by topic and in the order of time.
async function indexedMessages(bytes, options) {
  const reader = await mcap.McapIndexedReader.Initialize({ readable: new BytesReadable(bytes), decompressHandlers });
  const decoders = new Map();
  for (const [id, channel] of reader.channelsById) {
    const schema = reader.schemasById.get(channel.schemaId);
    const text = new TextDecoder().decode(schema.data);
    if (schema.encoding === 'ros2msg') {
      equal(channel.messageEncoding, 'cdr', channel.topic);
      const decoder = new serialization.MessageReader(rosmsg.parse(text, { ros2: true }));
      decoders.set(id, (data) => decoder.readMessage(data));
    } else {
      equal(schema.encoding, 'jsonschema', channel.topic);
      equal(JSON.parse(text).type, 'object', channel.topic);
      decoders.set(id, (data) => JSON.parse(new TextDecoder().decode(data)));
    }
  }
  const topics = {};
  for await (const message of reader.readMessages(options)) {
    const { topic } = reader.channelsById.get(message.channelId);
    (topics[topic] ??= []).push({ time: message.logTime, message: decoders.get(message.channelId)(message.data) });
  }
  return { reader, topics };
}

const cases = {
  async 'an indexed reader finds every sample with the numbers of the CSV'() {
    const bytes = readFileSync(exported('mcap'));
    const { reader, topics } = await indexedMessages(bytes);
    equal(reader.header.profile, 'ros2', 'profile');
    check(reader.chunkIndexes.length > 1, 'several chunks');
    equal(topics['/hoist/record'].length, rows.length, 'records');
    topics['/hoist/record'].forEach(({ message }, i) => {
      for (const name of names.slice(1)) equal(message[name], number(i, name), `${name} of row ${i}`);
    });
    topics['/odom'].forEach(({ message }, i) => {
      equal(message.pose.pose.position.x, number(i, 'x_m'), 'x');
      equal(message.pose.pose.position.y, number(i, 'y_m'), 'y');
      // The last bit of a sine differs between libraries.
      check(Math.abs(message.pose.pose.orientation.z - Math.sin(number(i, 'psi_rad') / 2)) < 1e-15, 'heading');
      equal(message.twist.twist.linear.x, number(i, 'speed_m_s'), 'speed');
      equal(message.twist.twist.angular.z, number(i, 'yaw_rate_rad_s'), 'turn rate');
    });
    equal(topics['/odom'].length, rows.length, '/odom');
    topics['/imu/base'].forEach(({ message }, i) => equal(message.angular_velocity.z, number(i, 'base_yaw_rate_rad_s'), 'yaw rate'));
    for (const topic of ['/imu/left', '/imu/right', '/imu/base']) equal(topics[topic].length, rows.length, topic);
    for (const topic of ['/tf', '/pose', '/joint_states']) equal(topics[topic].length, rows.length / 2, topic);
    equal(topics['/tf'][5].message.transforms.length, 4, 'transforms');
    check(topics['/diagnostics'].some(({ message }) => message.status.length === 2), 'a fault is told');
    check(topics['/battery_state'].length >= 28, 'one state of the batteries each second');
    equal(topics['/hoist/events'].length, 3, 'events');
    equal(topics['/hoist/events'][1].message.text, 'turned; "left", by the ramp', 'marker');
    const inGap = Number(topics['/hoist/events'][2].time - topics['/hoist/record'][0].time) / 1e9;
    check(Math.abs(inGap - 14.2) < 0.001, `the marker in the gap stands at ${inGap} s`);
    for (const list of Object.values(topics))
      for (let i = 1; i < list.length; i += 1) check(list[i].time >= list[i - 1].time, 'time runs forward');
    equal(reader.statistics.messageCount, BigInt(Object.values(topics).reduce((sum, list) => sum + list.length, 0)), 'statistics');
  },

  async 'a reader asks for one topic and a second of it only'() {
    const bytes = readFileSync(exported('mcap'));
    const all = (await indexedMessages(bytes, { topics: ['/odom'] })).topics['/odom'];
    const start = all[0].time + 5_000_000_000n;
    const some = (await indexedMessages(bytes, { topics: ['/odom'], startTime: start, endTime: start + 1_000_000_000n })).topics['/odom'];
    const expected = all.filter(({ time }) => time >= start && time <= start + 1_000_000_000n).length;
    check(expected > 95, 'a second has about 100 samples');
    equal(some.length, expected, 'messages of that second');
  },

  async 'a streaming reader finds the same, and every checksum is right'() {
    const reader = new mcap.McapStreamReader({ decompressHandlers, validateCrcs: true });
    reader.append(readFileSync(exported('mcap')));
    const counts = {};
    for (let record = reader.nextRecord(); record; record = reader.nextRecord()) counts[record.type] = (counts[record.type] ?? 0) + 1;
    check(reader.done(), 'read to the end');
    for (const type of ['Header', 'DataEnd', 'Statistics', 'Footer']) equal(counts[type], 1, type);
    equal(counts.Attachment, 2, 'attachments');
    equal(counts.Metadata, 1, 'metadata');
  },

  async 'attachments and metadata name the session'() {
    const { reader } = await indexedMessages(readFileSync(exported('mcap', '--columns', 'x_m')), { topics: ['/none'] });
    for await (const metadata of reader.readMetadata()) {
      equal(metadata.metadata.get('subject'), 'P-017', 'subject');
      equal(metadata.metadata.get('controlled_by'), 'hoist-control 0.1.0+ddddeeeeffff', 'core');
    }
    const files = {};
    for await (const file of reader.readAttachments()) files[file.name] = JSON.parse(new TextDecoder().decode(file.data));
    equal(files['parameters.json'].lean_range_rad.unit, 'rad', 'unit of a parameter');
    equal(files['manifest.json'].parameter_changes[0].value, 0.125, 'a changed parameter');
    equal(files['manifest.json'].columns.length, 1, 'chosen columns');
  },

  async 'a MAT-file holds the numbers of the CSV, for two readers'() {
    const file = exported('mat');
    const bytes = readFileSync(file);
    const { data } = mat.read(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    for (const name of names.slice(1)) {
      const values = [data[name]].flat(Infinity);
      equal(values.length, rows.length, `length of ${name}`);
      values.forEach((value, i) => equal(Number(value), number(i, name), `${name} of row ${i}`));
    }
    const text = (codes) => JSON.parse(String.fromCharCode(...[codes].flat(Infinity)));
    equal(text(data.events)[1].text, 'turned; "left", by the ramp', 'marker');
    equal(text(data.manifest).session.subject, 'P-017', 'manifest');
    // matdump of libmatio prints the values, one a line, reals with six digits.
    for (const name of ['left_counts', 'mode', 'fault_bits', 'x_m', 'time_s']) {
      const told = execFileSync('matdump', ['-d', file, name], { encoding: 'utf8' }).trim().split(/\s+/).map(Number);
      equal(told.length, rows.length, `matdump: length of ${name}`);
      told.forEach((value, i) => {
        const expected = number(i, name);
        check(Math.abs(value - expected) <= 1e-5 * Math.abs(expected), `matdump: ${name} of row ${i}: ${value}, expected ${expected}`);
      });
    }
  },
};

let failed = 0;
const results = [];
for (const [name, run] of Object.entries(cases)) {
  const begin = Date.now();
  try {
    await run();
    console.log(`passed: ${name} (${Date.now() - begin} ms)`);
    results.push(`<testcase name="${escape(name)}" classname="export_readers" status="run" result="completed"/>`);
  } catch (error) {
    failed += 1;
    console.log(`failed: ${name}: ${error.stack}`);
    results.push(`<testcase name="${escape(name)}" classname="export_readers" status="run" result="completed"><failure message="${escape(error.message)}"/></testcase>`);
  }
}
writeReport(results.join(''));
rmSync(folder, { recursive: true });
process.exit(failed === 0 ? 0 : 1);
