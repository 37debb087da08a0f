// One binary telemetry message: a header, then `count` samples, little endian: whole records (kind 1) or the blocks of chosen topics (kind 2).
import { layoutHash } from '../contract/messages.gen';
import type { TopicName } from '../contract/rest.gen';
import { readTickRecord, tickRecordBytes, type TickRecord } from '../contract/signals.gen';
import { topicBlocks, topicsHash, type TopicBlock, type TopicValues } from '../contract/topics.gen';

/** The values of these topics; those of `state` are in every sample. */
export type SampleOf<T extends TopicName> = Pick<TickRecord, TopicValues['state'] | TopicValues[T]>;
/** At every choice. */
export type Sample = SampleOf<'state'> & Partial<TickRecord>;

export const frameHeaderBytes = 16;
export const topicsHeaderBytes = 20;
const recordsKind = 1;
const topicsKind = 2;
export const frameVersion = 1;
/** Above the server's batch size; a larger count is a damaged frame. */
export const recordsPerFrameMost = 1000;

export type FrameResult =
  { ok: true; topics: readonly TopicName[]; samples: Sample[] } | { ok: false; why: 'short' | 'kind' | 'version' | 'layout' | 'length' };

interface Layout {
  headerBytes: number;
  sampleBytes: number;
  hash: string;
  topics: readonly TopicName[];
  read: (view: DataView, at: number) => Sample;
}

const records: Layout = { headerBytes: frameHeaderBytes, sampleBytes: tickRecordBytes, hash: layoutHash, topics: ['all'], read: readTickRecord };

function layoutOf(view: DataView, kind: number): Layout | null {
  if (kind === recordsKind) return records;
  if (view.byteLength < topicsHeaderBytes) return null;
  const bits = view.getUint32(frameHeaderBytes, true);
  const blocks = topicBlocks.filter((_, bit) => ((bits >>> bit) & 1) === 1);
  return {
    headerBytes: topicsHeaderBytes,
    sampleBytes: blocks.reduce((sum, block) => sum + block.bytes, 0),
    hash: topicsHash,
    topics: blocks.map((block) => block.name),
    read: (view, at) => readBlocks(blocks, view, at),
  };
}

/** The server puts `state` into every sample. */
function readBlocks(blocks: readonly TopicBlock[], view: DataView, at: number): Sample {
  const sample = {} as Sample;
  for (const block of blocks) {
    Object.assign(sample, block.read(view, at));
    at += block.bytes;
  }
  return sample;
}

/** Reads a complete telemetry message, or refuses it. */
export function readFrame(buffer: ArrayBuffer): FrameResult {
  if (buffer.byteLength < frameHeaderBytes) return { ok: false, why: 'short' };
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  if (kind !== recordsKind && kind !== topicsKind) return { ok: false, why: 'kind' };
  if (view.getUint8(1) !== frameVersion) return { ok: false, why: 'version' };
  const layout = layoutOf(view, kind);
  if (layout === null) return { ok: false, why: 'short' };
  const { headerBytes, sampleBytes, topics } = layout;
  const count = view.getUint16(2, true);
  const hash = view.getBigUint64(8, true).toString(16).padStart(16, '0');
  if (view.getUint32(4, true) !== sampleBytes || hash !== layout.hash) return { ok: false, why: 'layout' };
  if (count > recordsPerFrameMost || buffer.byteLength !== headerBytes + count * sampleBytes) return { ok: false, why: 'length' };
  const samples: Sample[] = [];
  for (let i = 0; i < count; i++) samples.push(layout.read(view, headerBytes + i * sampleBytes));
  return { ok: true, topics, samples };
}
