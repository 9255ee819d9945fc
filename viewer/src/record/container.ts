// The file of a recording: the server's own binary messages, each with the time it came.
// docs/page.md sets the format down.
//
//   0  8 bytes  "THENARPG"          then per message:
//   8  u32      version, 1            0  u32  length of the message, bytes
//  12  u32      0                     4  u32  CRC-32 of the message
//                                     8  f64  time since the recording began, s
//                                    16       the message (model or snapshot)

import { crc32 } from "./crc32";
import { upgrade } from "./upgrade";

export const MAGIC = "THENARPG";
export const VERSION = 1;
const HEADER = 16;
const ENTRY = 16;
const KIND_MODEL = 1;
const KIND_SNAPSHOT = 2;
const WITHOUT_NORMALS =
  "It was made before contacts carried their normals: contacts and pressure are not shown.";

/** One message of the server. */
export interface Entry {
  /** Since the recording began, s. */
  readonly time: number;
  readonly message: ArrayBuffer;
}

export class RecordingError extends Error {
  override readonly name = "RecordingError";
}

export interface Loaded {
  readonly entries: readonly Entry[];
  /** What is missing and why, or null: the file is whole. */
  readonly damage: string | null;
  /** What an older page did not record yet, or null. */
  readonly lacks: string | null;
}

export function isModel(message: ArrayBuffer): boolean {
  return new DataView(message).getUint8(0) === KIND_MODEL;
}

export function epochOf(message: ArrayBuffer): number {
  return new DataView(message).getUint32(4, true);
}

/** The file in pieces, ready for a `Blob`. */
export function write(entries: Iterable<Entry>): ArrayBuffer[] {
  const header = new ArrayBuffer(HEADER);
  const view = new DataView(header);
  for (let i = 0; i < MAGIC.length; i++) view.setUint8(i, MAGIC.charCodeAt(i));
  view.setUint32(8, VERSION, true);
  const pieces = [header];
  for (const { time, message } of entries) {
    const entry = new DataView(new ArrayBuffer(ENTRY));
    entry.setUint32(0, message.byteLength, true);
    entry.setUint32(4, crc32(new Uint8Array(message)), true);
    entry.setFloat64(8, time, true);
    pieces.push(entry.buffer, message);
  }
  return pieces;
}

/** Reads a file. What follows a damaged place is left out and `damage` says so; a file of another
 * kind, or without one whole model and snapshot, is refused. */
export function read(file: ArrayBuffer): Loaded {
  checkHeader(file);
  const view = new DataView(file);
  const entries: Entry[] = [];
  let damage: string | null = null;
  let at = HEADER;
  while (at < file.byteLength) {
    const entry = readEntry(view, at, entries);
    if (typeof entry === "string") {
      const n = entries.length + 1;
      damage = `Message ${n}, at byte ${at}, ${entry}; what follows is left out.`;
      break;
    }
    entries.push(entry);
    at += ENTRY + entry.message.byteLength;
  }
  if (!entries.some(({ message }) => !isModel(message))) {
    throw new RecordingError(`The recording holds no whole snapshot.${damage === null ? "" : ` ${damage}`}`);
  }
  const now = entries.map(({ message }) => upgrade(message, isModel(message)));
  const whole = entries.map(({ time }, i) => ({ time, message: now[i].message }));
  const lacks = now.some(({ lacks }) => lacks) ? WITHOUT_NORMALS : null;
  return { entries: whole, damage, lacks };
}

function checkHeader(file: ArrayBuffer): void {
  const bytes = new Uint8Array(file, 0, Math.min(HEADER, file.byteLength));
  const magic = String.fromCharCode(...bytes.subarray(0, MAGIC.length));
  if (magic !== MAGIC) throw new RecordingError("This is no recording of the Thenar page.");
  if (file.byteLength < HEADER) throw new RecordingError("The recording is cut off in its header.");
  const version = new DataView(file).getUint32(8, true);
  if (version !== VERSION) {
    throw new RecordingError(`The recording has version ${version}; this page reads ${VERSION}.`);
  }
}

/** The entry at a byte, or what is wrong with it. */
function readEntry(view: DataView, at: number, before: readonly Entry[]): Entry | string {
  const left = view.byteLength - at - ENTRY;
  if (left < 0) return "is cut off";
  const length = view.getUint32(at, true);
  if (length > left) return "is cut off";
  if (length < 8) return "is too short";
  const bytes = new Uint8Array(view.buffer, at + ENTRY, length);
  if (crc32(bytes) !== view.getUint32(at + 4, true)) return "is damaged (wrong checksum)";
  const time = view.getFloat64(at + 8, true);
  const earlier = before.length === 0 ? 0 : before[before.length - 1].time;
  if (!(time >= earlier) || !Number.isFinite(time)) return "is out of order in time";
  const message = bytes.slice().buffer;
  const kind = bytes[0];
  if (kind !== KIND_MODEL && kind !== KIND_SNAPSHOT) return `has the unknown kind ${kind}`;
  if (before.length === 0 && kind !== KIND_MODEL) return "is no model, which must come first";
  return { time, message };
}
