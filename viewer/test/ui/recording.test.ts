// Recordings: what is written is read back to the byte, damage costs only what follows it, and
// memory stays bounded.

import { describe, expect, it } from "vitest";
import { Quaternion, Vector3 } from "three";
import { read, write, type Entry } from "../../src/record/container";
import { crc32 } from "../../src/record/crc32";
import { Player } from "../../src/record/player";
import { Recorder } from "../../src/record/recorder";
import { modelMessage, snapshotMessage } from "./world";

const place = { position: new Vector3(), rotation: new Quaternion(), angles: new Float64Array(20) };
const snapshot = (i: number, epoch = 1) => snapshotMessage({ place, number: i, time: i / 10, epoch });

function recording(snapshots: number): Entry[] {
  const entries: Entry[] = [{ time: 0, message: modelMessage() }];
  for (let i = 0; i < snapshots; i++) entries.push({ time: i / 10, message: snapshot(i) });
  return entries;
}

async function file(entries: Entry[]): Promise<ArrayBuffer> {
  return new Blob(write(entries)).arrayBuffer();
}

/** A message as protocol 1 or 2 had it: three numbers per digit; with so many contacts of 0.25 m². */
function before(version: number, { time, message }: Entry, contacts: number): Entry {
  const old = new Uint8Array(message.slice(0));
  old[1] = version;
  if (old[0] === 1) return { time, message: old.buffer };
  const at = message.byteLength - 4 * 24;
  const words = Array.from(new Float32Array(message, at)).filter((_, i) => i % 4 !== 3);
  const out = new Uint8Array(at + 4 * words.length + 48 * contacts);
  out.set(old.subarray(0, at));
  out[76] = contacts;
  new Float32Array(out.buffer, at, words.length).set(words);
  for (let i = 0; i < contacts; i++) new DataView(out.buffer).setFloat32(at + 4 * words.length + 48 * i + 36, 0.25, true);
  return { time, message: out.buffer };
}

describe("recording files", () => {
  it("use the checksum of zip", () => {
    // The check value of CRC-32/ISO-HDLC.
    expect(crc32(new TextEncoder().encode("123456789"))).toBe(0xcbf43926);
  });

  it("are read back to the byte", async () => {
    const entries = recording(5);
    const loaded = read(await file(entries));
    expect(loaded.damage).toBeNull();
    expect(loaded.entries).toEqual(entries);
  });

  it("of protocol 1 are shown without contacts, and say so", async () => {
    const loaded = read(await file(recording(2).map((entry, i) => before(1, entry, i === 2 ? 1 : 0))));
    expect(loaded.lacks).toMatch(/contacts and pressure are not shown/);
    expect(loaded.entries).toEqual(recording(2));
    expect(new Player(loaded.entries).show(0).snapshot.contacts.count).toBe(0);
    expect(read(await file(recording(2))).lacks).toBeNull();
  });

  it("of protocol 2 are shown with force over area as pressure", async () => {
    const fingers = Array.from({ length: 24 }, (_, i) => i + 1);
    const entries = [recording(1)[0], { time: 0, message: snapshotMessage({ place, fingers }) }];
    const loaded = read(await file(entries.map((entry, i) => before(2, entry, i))));
    expect(loaded.lacks).toBeNull();
    const { snapshot: shown } = new Player(loaded.entries).show(0);
    expect(shown.contacts.count).toBe(1);
    expect(shown.contacts.area(0)).toBe(0.25);
    // Each fourth number is force over area, whatever was sent since.
    const [normal, area] = [(i: number) => fingers[i - 3], (i: number) => fingers[i - 1]];
    const wanted = fingers.map((x, i) => (i % 4 === 3 ? Math.fround(normal(i) / area(i)) : x));
    expect(Array.from(shown.fingers)).toEqual(wanted);
  });

  it("cut off anywhere give all whole messages before the cut", async () => {
    const entries = recording(4);
    const whole = await file(entries);
    const ends = entries.map(
      (
        (at) => (entry: Entry) =>
          (at += 16 + entry.message.byteLength)
      )(16),
    );
    for (let length = 0; length < whole.byteLength; length += 7) {
      const kept = ends.filter((end) => end <= length).length;
      if (kept < 2) {
        expect(() => read(whole.slice(0, length))).toThrow(/recording/i);
        continue;
      }
      const loaded = read(whole.slice(0, length));
      expect(loaded.entries.length).toBe(kept);
      expect(loaded.damage !== null).toBe(!ends.includes(length));
    }
  });

  it("notice a flipped bit anywhere in a message", async () => {
    const whole = await file(recording(3));
    const second = 16 + 16 + modelMessage().byteLength + 16;
    for (const offset of [0, 11, 100, 500]) {
      const hurt = whole.slice(0);
      new Uint8Array(hurt)[second + 16 + snapshot(0).byteLength + offset] ^= 4;
      const loaded = read(hurt);
      expect(loaded.entries.length).toBe(2);
      expect(loaded.damage).toMatch(/^Message 3, at byte \d+, /);
    }
  });

  it("of another kind or version are refused with the reason", async () => {
    const whole = await file(recording(1));
    expect(() => read(new TextEncoder().encode("not a recording").buffer)).toThrow("no recording");
    const newer = whole.slice(0);
    new DataView(newer).setUint32(8, 9, true);
    expect(() => read(newer)).toThrow("version 9");
    expect(() => read(new ArrayBuffer(0))).toThrow("no recording");
    const headless = await file(recording(2).slice(1));
    expect(() => read(headless)).toThrow("no model, which must come first");
  });
});

describe("the recorder", () => {
  const size = snapshot(0).byteLength;

  it("keeps the newest seconds", () => {
    const recorder = new Recorder({ seconds: 2, bytes: 1e9 });
    recorder.begin(modelMessage(), 50);
    for (let i = 0; i < 5000; i++) recorder.add(snapshot(i), 50 + i / 100);
    expect(recorder.snapshots).toBe(201);
    expect(recorder.dropped).toBe(4799);
    expect(recorder.bytes).toBe(modelMessage().byteLength + 201 * size);
    const entries = recorder.entries();
    expect(entries[0].time).toBe(0);
    expect(entries.at(-1)!.time).toBeCloseTo(2, 9);
    expect(new Player(entries).length).toBe(201);
  });

  it("keeps within its memory, over several models", () => {
    const bytes = 20 * size + 3 * modelMessage().byteLength;
    const recorder = new Recorder({ seconds: 1e9, bytes });
    recorder.begin(modelMessage(1), 0);
    for (let epoch = 1; epoch <= 9; epoch++) {
      if (epoch > 1) recorder.add(modelMessage(epoch), epoch);
      for (let i = 0; i < 15; i++) recorder.add(snapshot(i, epoch), epoch + i / 20);
      expect(recorder.bytes).toBeLessThanOrEqual(bytes);
    }
    const player = new Player(recorder.entries());
    player.step(1e9);
    expect(player.show(0).snapshot.epoch).toBe(9);
    player.step(-1e9);
    const { model, snapshot: first } = player.show(0);
    expect(first.epoch).toBe(model.epoch);
  });
});

describe("the player", () => {
  it("goes by time, by frame, and stops at the end", () => {
    const player = new Player(recording(11));
    expect(player.duration).toBeCloseTo(1, 12);
    player.playing = true;
    player.speed = 0.5;
    player.advance(0.9);
    expect(player.show(0).snapshot.number).toBe(4);
    player.step(2);
    expect(player.index).toBe(6);
    expect(player.playing).toBe(false);
    player.step(-100);
    expect(player.index).toBe(0);
    player.playing = true;
    player.advance(100);
    expect(player.index).toBe(10);
    expect(player.playing).toBe(false);
    player.time = 0.55;
    expect(player.show(0).snapshot.time).toBeCloseTo(0.5, 12);
  });
});
