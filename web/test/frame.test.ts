import { describe, expect, it } from 'vitest';
import { layoutHash } from '../src/contract/messages.gen';
import { signals, tickRecordBytes } from '../src/contract/signals.gen';
import { frameHeaderBytes, readFrame } from '../src/link/frame';

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
    expect(read.ok && read.records).toEqual(sent);
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
    expect(read.ok && read.records[0]).toMatchObject(sent);
  });

  it.each([
    ['a frame shorter than its header', new ArrayBuffer(15), 'short'],
    ['another kind', frame([{}], { kind: 2 }), 'kind'],
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
    expect(readFrame(frame([]))).toEqual({ ok: true, records: [] });
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
