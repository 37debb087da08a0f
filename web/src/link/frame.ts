// One binary telemetry message: a header of 16 bytes, then `count` tick records, little endian.
import { readTickRecord, tickRecordBytes, type TickRecord } from '../contract/signals.gen';
import { layoutHash } from '../contract/messages.gen';

export const frameHeaderBytes = 16;
export const frameKindTelemetry = 1;
export const frameVersion = 1;
/** Above the server's batch size; a larger count is a damaged frame. */
export const recordsPerFrameMost = 1000;

export type FrameResult = { ok: true; records: TickRecord[] } | { ok: false; why: 'short' | 'kind' | 'version' | 'layout' | 'length' };

/** Reads a complete telemetry message, or refuses it. */
export function readFrame(buffer: ArrayBuffer): FrameResult {
  if (buffer.byteLength < frameHeaderBytes) return { ok: false, why: 'short' };
  const view = new DataView(buffer);
  if (view.getUint8(0) !== frameKindTelemetry) return { ok: false, why: 'kind' };
  if (view.getUint8(1) !== frameVersion) return { ok: false, why: 'version' };
  const count = view.getUint16(2, true);
  const hash = view.getBigUint64(8, true).toString(16).padStart(16, '0');
  if (view.getUint32(4, true) !== tickRecordBytes || hash !== layoutHash) return { ok: false, why: 'layout' };
  if (count > recordsPerFrameMost || buffer.byteLength !== frameHeaderBytes + count * tickRecordBytes) return { ok: false, why: 'length' };
  const records: TickRecord[] = [];
  for (let i = 0; i < count; i++) records.push(readTickRecord(view, frameHeaderBytes + i * tickRecordBytes));
  return { ok: true, records };
}
