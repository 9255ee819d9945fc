// The bundle that the hand landmarker loads: a stored zip of the two models, each with its metadata, and otherwise unchanged.

import { expect, it } from "vitest";
import { elements, fields, flatbuffer, follow, table, tables, text, u32 } from "../../build/flatbuffer";
import { storedZip, withMetadata } from "../../build/hand-task";
import { task } from "../../build/mediapipe";
import { crc32 } from "../../src/record/crc32";

/** Files of a stored zip, from its directory. */
function unzip(zip: Buffer): { name: string; at: number; bytes: Buffer }[] {
  const end = zip.lastIndexOf("PK\x05\x06");
  let at = zip.readUInt32LE(end + 16);
  return Array.from({ length: zip.readUInt16LE(end + 10) }, () => {
    expect(zip.toString("latin1", at, at + 4)).toBe("PK\x01\x02");
    expect(zip.readUInt16LE(at + 10), "stored").toBe(0);
    const [crc, size, name] = [zip.readUInt32LE(at + 16), zip.readUInt32LE(at + 24), zip.readUInt16LE(at + 28)];
    const local = zip.readUInt32LE(at + 42);
    expect(zip.toString("latin1", local, local + 4)).toBe("PK\x03\x04");
    const start = local + 30 + zip.readUInt16LE(local + 26) + zip.readUInt16LE(local + 28);
    const bytes = zip.subarray(start, start + size);
    expect(crc32(bytes)).toBe(crc);
    const file = { name: zip.toString("latin1", at + 46, at + 46 + name), at: start, bytes };
    at += 46 + name + zip.readUInt16LE(at + 30);
    return file;
  });
}

/** Bytes and places of a model's buffers. */
function buffers(model: Buffer): { at: number; bytes: Buffer }[] {
  const [, , , , list] = fields(model, follow(model, 0), 8);
  return elements(model, follow(model, list!)).map((buffer) => {
    const [data] = fields(model, buffer, 1);
    if (data === null) return { at: 0, bytes: Buffer.alloc(0) };
    const at = follow(model, data);
    return { at: at + 4, bytes: model.subarray(at + 4, at + 4 + model.readUInt32LE(at)) };
  });
}

/** What divides pixels, and what is taken off before, by the metadata that a model carries. */
function normalization(model: Buffer): { mean: number; std: number } {
  const [, , , , , , list] = fields(model, follow(model, 0), 8);
  const entry = elements(model, follow(model, list!)).at(-1)!;
  const [name, buffer] = fields(model, entry, 2);
  const said = follow(model, name!);
  expect(model.toString("latin1", said + 4, said + 4 + model.readUInt32LE(said))).toBe("TFLITE_METADATA");
  const { bytes } = buffers(model)[model.readUInt32LE(buffer!)]!;
  expect(bytes.toString("latin1", 4, 8)).toBe("M001");
  const only = (at: number, field: number) => elements(bytes, follow(bytes, fields(bytes, at, field + 1)[field]!))[0]!;
  const graph = only(follow(bytes, 0), 3);
  const unit = only(only(graph, 2), 4);
  const [kind, options] = fields(bytes, unit, 2);
  expect(bytes.readUInt8(kind!), "NormalizationOptions").toBe(1);
  const [mean, std] = fields(bytes, follow(bytes, options!), 2).map((at) => follow(bytes, at!));
  return { mean: bytes.readFloatLE(mean! + 4), std: bytes.readFloatLE(std! + 4) };
}

it("bundles both models on sixteen bytes, with pixels from 0 to 1", () => {
  const files = unzip(task());
  expect(files.map(({ name }) => name)).toEqual(["hand_detector.tflite", "hand_landmarks_detector.tflite"]);
  for (const { at, bytes } of files) {
    expect(at % 16).toBe(0);
    expect(normalization(Buffer.from(bytes))).toEqual({ mean: 0, std: 255 });
    // Weights stay aligned.
    for (const { at: place, bytes: data } of buffers(Buffer.from(bytes))) if (data.length > 0) expect(place % 16).toBe(0);
  }
});

it("keeps what a model has: its buffers, its words, metadata of its own", () => {
  const data = (...bytes: number[]) => table({ kind: "bytes", bytes: Uint8Array.from(bytes) });
  const model = flatbuffer(
    table(u32(3), null, null, text("a model"), tables(table(), data(1, 2, 3)), null, tables(table(text("mine"), u32(1)))),
    "TFL3",
  );
  const made = withMetadata(model);
  const kept = buffers(made);
  expect(kept.length).toBe(3);
  expect([...kept[1]!.bytes]).toEqual([1, 2, 3]);
  const [version, , , words, , , metadata] = fields(made, follow(made, 0), 8);
  expect(made.readUInt32LE(version!)).toBe(3);
  expect(made.toString("latin1", follow(made, words!) + 4, follow(made, words!) + 11)).toBe("a model");
  expect(elements(made, follow(made, metadata!)).length).toBe(2);
  expect(normalization(made)).toEqual({ mean: 0, std: 255 });
});

it("refuses what is no model", () => {
  expect(() => withMetadata(Buffer.from("not a model at all"))).toThrow("no model");
});

it("stores files of any name and length", () => {
  const files = unzip(storedZip([["a", Buffer.from("x")], ["bcd", Buffer.alloc(1000, 7)]]));
  expect(files.map(({ name, bytes }) => [name, bytes.length])).toEqual([["a", 1], ["bcd", 1000]]);
});
