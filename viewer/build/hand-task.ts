// Makes the bundle that MediaPipe's hand landmarker loads from the two models that come with MediaPipe Hands. They lack what
// the landmarker wants to know of them, how pixels become numbers: it is added, as metadata of TensorFlow Lite.

import { crc32 } from "../src/record/crc32.ts";
import { elements, fields, flatbuffer, floats, follow, later, table, tables, text, u32, u8, type Value } from "./flatbuffer.ts";

/** Fields of a model, numbered as in TensorFlow Lite's schema.fbs. */
const MODEL_FIELDS = 8;
const [BUFFERS, METADATA] = [4, 6];

/** metadata_schema.fbs: pixels from 0 to 255, red, green and blue, are divided by 255. */
function inputMetadata(): Buffer {
  const NORMALIZATION = 1;
  const IMAGE = 2;
  const RGB = 1;
  const content = table(u8(IMAGE), table(u8(RGB)));
  const unit = table(u8(NORMALIZATION), table(floats(0), floats(255)));
  const tensor = table(text("image"), null, null, content, tables(unit));
  return flatbuffer(table(text("hand"), null, null, tables(table(null, null, tables(tensor)))), "M001");
}

/** A model of TensorFlow Lite, with metadata for its only input. */
export function withMetadata(model: Buffer): Buffer {
  if (model.toString("latin1", 4, 8) !== "TFL3") throw new Error("This is no model of TensorFlow Lite.");
  const places = fields(model, follow(model, 0), MODEL_FIELDS);
  const [buffers, metadata] = [places[BUFFERS], places[METADATA]];
  if (buffers === null) throw new Error("The model has no buffers.");
  const kept = elements(model, follow(model, buffers)).map(later);
  const old = metadata === null ? [] : elements(model, follow(model, metadata)).map(later);
  const data = table({ kind: "bytes", bytes: inputMetadata() });
  const entry = table(text("TFLITE_METADATA"), u32(kept.length));
  const root = places.map((place, f): Value | null => {
    if (f === BUFFERS) return tables(...kept, data);
    if (f === METADATA) return tables(...old, entry);
    if (place === null) return null;
    // The version is a number; all else is elsewhere, where it stays.
    return f === 0 ? u32(model.readUInt32LE(place)) : later(follow(model, place));
  });
  return flatbuffer(table(...root), "TFL3", model);
}

/** What is asked of the start of a model in the bundle, bytes. */
const ALIGNMENT = 16;

/** A zip archive whose files are stored as they are (APPNOTE.TXT 4.3), each starting on 16 bytes. */
export function storedZip(files: readonly (readonly [string, Buffer])[]): Buffer {
  const parts: Buffer[] = [];
  const directory: Buffer[] = [];
  let at = 0;
  for (const [name, bytes] of files) {
    // An extra field fills up to where the file starts.
    const bare = 30 + name.length + 4;
    const extra = Buffer.alloc(4 + ((ALIGNMENT - ((at + bare) % ALIGNMENT)) % ALIGNMENT));
    extra.writeUInt16LE(0xd935, 0);
    extra.writeUInt16LE(extra.length - 4, 2);
    const common = Buffer.alloc(26);
    common.writeUInt16LE(20, 0);
    // 1 January 1980: the same bytes whenever it is made.
    common.writeUInt16LE(0x21, 8);
    common.writeUInt32LE(crc32(bytes), 10);
    common.writeUInt32LE(bytes.length, 14);
    common.writeUInt32LE(bytes.length, 18);
    common.writeUInt16LE(name.length, 22);
    const local = Buffer.from(common);
    local.writeUInt16LE(extra.length, 24);
    parts.push(Buffer.from("PK\x03\x04"), local, Buffer.from(name), extra, bytes);
    const tail = Buffer.alloc(14);
    tail.writeUInt32LE(at, 10);
    directory.push(Buffer.from("PK\x01\x02\x14\x00", "latin1"), common, tail, Buffer.from(name));
    at += 30 + name.length + extra.length + bytes.length;
  }
  const list = Buffer.concat(directory);
  const end = Buffer.alloc(18);
  end.writeUInt16LE(files.length, 4);
  end.writeUInt16LE(files.length, 6);
  end.writeUInt32LE(list.length, 8);
  end.writeUInt32LE(at, 12);
  return Buffer.concat([...parts, list, Buffer.from("PK\x05\x06"), end]);
}

/** The hand landmarker's bundle. */
export function handTask(detector: Buffer, landmarks: Buffer): Buffer {
  return storedZip([
    ["hand_detector.tflite", withMetadata(detector)],
    ["hand_landmarks_detector.tflite", withMetadata(landmarks)],
  ]);
}
