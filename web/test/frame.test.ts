import { describe, expect, it } from 'vitest';
import { layoutHash } from '../src/contract/messages.gen';
import { signals, tickRecordBytes } from '../src/contract/signals.gen';
import { topicBlocks, topicsHash } from '../src/contract/topics.gen';
import { frameHeaderBytes, readFrame, topicsHeaderBytes } from '../src/link/frame';

/** A frame built byte by byte from the table, independent of the tested reader. */
function frame(
  records: Record<string, number>[],
  head: { kind?: number; version?: number; count?: number; bytes?: number; hash?: bigint } = {},
): ArrayBuffer {
  const bytes = new Uint8Array(frameHeaderBytes + records.length * tickRecordBytes);
  const put = (at: number, size: number, value: bigint) => {
    for (let i = 0; i < size; i++) bytes[at + i] = Number((value >> BigInt(8 * i)) & 0xffn);
  };
  put(0, 1, BigInt(head.kind ?? 1));
  put(1, 1, BigInt(head.version ?? 1));
  put(2, 2, BigInt(head.count ?? records.length));
  put(4, 4, BigInt(head.bytes ?? tickRecordBytes));
  put(8, 8, head.hash ?? BigInt(`0x${layoutHash}`));
  records.forEach((record, r) => {
    for (const { name, type, offset } of signals) {
      const at = frameHeaderBytes + r * tickRecordBytes + offset;
      const value = record[name] ?? 0;
      if (type === 'f32') put(at, 4, BigInt(new Uint32Array(new Float32Array([value]).buffer)[0]!));
      else put(at, { u64: 8, u32: 4, i32: 4, u16: 2, u8: 1 }[type], BigInt.asUintN(64, BigInt(value)));
    }
  });
  return bytes.buffer;
}

describe('readFrame', () => {
  it('reads every field of every record at its place', () => {
    // Each field gets its own value, so that a swapped or shifted one shows.
    const record = (base: number) =>
      Object.fromEntries(
        signals.map(({ name, type }, i) => [name, type === 'u8' ? (base + i) % 250 : type === 'f32' ? (base + i) / 8 : base * 1000 + i]),
      );
    const sent = [record(3), record(17)];
    const read = readFrame(frame(sent));
    expect(read.ok && read.samples).toEqual(sent);
  });

  it('reads the numbers that a careless reader gets wrong', () => {
    const sent = {
      tick: 2 ** 40 + 1,
      time_ns: 2 ** 52 + 12345,
      left_counts: -7,
      psi_rad: -12.5,
      fault_bits: 2 ** 52 + 2 ** 32 + 1,
      left_status_word: 0xffff,
      bumpers: 255,
    };
    const read = readFrame(frame([sent]));
    expect(read.ok && read.samples[0]).toMatchObject(sent);
  });

  it.each([
    ['a frame shorter than its header', new ArrayBuffer(15), 'short'],
    ['another kind', frame([{}], { kind: 3 }), 'kind'],
    ['another version', frame([{}], { version: 2 }), 'version'],
    ['another layout', frame([{}], { hash: 1n }), 'layout'],
    ['another record size', frame([{}], { bytes: tickRecordBytes + 8 }), 'layout'],
    ['fewer records than announced', frame([{}], { count: 2 }), 'length'],
    ['more records than announced', frame([{}, {}], { count: 1 }), 'length'],
    ['a record cut short', frame([{}, {}]).slice(0, -1), 'length'],
  ])('refuses %s whole', (_what, buffer, why) => {
    expect(readFrame(buffer)).toEqual({ ok: false, why });
  });

  it('takes an empty batch', () => {
    expect(readFrame(frame([]))).toEqual({ ok: true, topics: ['all'], samples: [] });
  });
});

/** Samples of chosen topics built from the names and types of their values. */
function blocks(
  names: readonly string[],
  samples: Record<string, number>[],
  head: { hash?: bigint; bits?: number; bytes?: number } = {},
): ArrayBuffer {
  const chosen = topicBlocks.filter((block) => names.includes(block.name));
  const sampleBytes = chosen.reduce((sum, block) => sum + block.bytes, 0);
  const view = new DataView(new ArrayBuffer(topicsHeaderBytes + samples.length * sampleBytes));
  view.setUint8(0, 2);
  view.setUint8(1, 1);
  view.setUint16(2, samples.length, true);
  view.setUint32(4, head.bytes ?? sampleBytes, true);
  view.setBigUint64(8, head.hash ?? BigInt(`0x${topicsHash}`), true);
  view.setUint32(16, head.bits ?? topicBlocks.reduce((bits, block, i) => (names.includes(block.name) ? bits + 2 ** i : bits), 0), true);
  let at = topicsHeaderBytes;
  for (const sample of samples)
    for (const block of chosen)
      for (const name of Object.keys(block.read(new DataView(new ArrayBuffer(block.bytes)), 0))) {
        const { type } = signals.find((row) => row.name === name)!;
        const value = sample[name] ?? 0;
        if (type === 'u64') view.setBigUint64(at, BigInt(value), true);
        else if (type === 'u32') view.setUint32(at, value, true);
        else if (type === 'i32') view.setInt32(at, value, true);
        else if (type === 'f32') view.setFloat32(at, value, true);
        else if (type === 'u16') view.setUint16(at, value, true);
        else view.setUint8(at, value);
        at += { u64: 8, u32: 4, i32: 4, f32: 4, u16: 2, u8: 1 }[type];
      }
  expect(at).toBe(view.byteLength);
  return view.buffer;
}

describe('samples of chosen topics', () => {
  it('have every value at its place, and no other', () => {
    const sample = (base: number) =>
      Object.fromEntries(
        signals.map(({ name, type }, i) => [name, type === 'u8' ? (base + i) % 250 : type === 'f32' ? (base + i) / 8 : base * 100 + i]),
      );
    const names = ['state', 'pose', 'calibration'];
    const read = readFrame(blocks(names, [sample(3), sample(17)]));
    if (!read.ok) throw new Error(read.why);
    expect(read.topics).toEqual(names);
    expect(read.samples).toHaveLength(2);
    expect(read.samples[1]).toMatchObject({ tick: sample(17).tick, fused_psi_rad: sample(17).fused_psi_rad, mode: sample(17).mode });
    expect(sample(3)).toMatchObject(read.samples[0]!);
    expect(read.samples[0]).not.toHaveProperty('speed_m_s');
  });

  it.each([
    ['of another table', blocks(['state'], [{}], { hash: 1n }), 'layout'],
    ['with other topics than its length says', blocks(['state'], [{}], { bits: 3 }), 'layout'],
    ['of another length', blocks(['state'], [{}], { bytes: 59 }), 'layout'],
    ['cut short', blocks(['state'], [{}]).slice(0, -1), 'length'],
    ['without their header', blocks(['state'], []).slice(0, 18), 'short'],
  ])('are refused whole: %s', (_what, buffer, why) => {
    expect(readFrame(buffer)).toEqual({ ok: false, why });
  });
});

describe('the signal table', () => {
  it('has no overlapping fields and none outside the record', () => {
    const size = { u64: 8, u32: 4, i32: 4, f32: 4, u16: 2, u8: 1 };
    const sorted = [...signals].sort((a, b) => a.offset - b.offset);
    for (let i = 0; i < sorted.length; i++) {
      const end = sorted[i]!.offset + size[sorted[i]!.type];
      expect(end).toBeLessThanOrEqual(sorted[i + 1]?.offset ?? tickRecordBytes);
    }
  });
});
