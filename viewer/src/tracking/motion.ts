// Recorded motion: JSON lines, the same files that scenes take (`kind = "recorded"`). The first line
// names the joints, every other line is one sample of one hand:
//
//   {"format":"hand-joints-jsonl","version":1,"joints":["wrist", …],"quat":"x,y,z,w"}
//   {"t":0.0112,"hand":"left","pos":[[x,y,z], …],"quat":[[x,y,z,w], …],"radius":[ … ]}
//
// Seconds, metres, right-handed, +y up. What breaks the rules is refused with line and cause.

import type { Side } from "../protocol/types";
import { JOINTS, JOINT_NAMES, JOINT_NUMBERS } from "./joints";

/** One hand's samples in order of time. */
export interface Track {
  /** s */
  readonly times: readonly number[];
  /** 200 numbers each, as `joints` messages. */
  readonly samples: readonly Float32Array[];
}

export interface Motion {
  readonly name: string;
  readonly tracks: Readonly<Partial<Record<Side, Track>>>;
  /** First and last time of any hand, s. */
  readonly start: number;
  readonly end: number;
}

export const FILE_BYTES_MAX = 64 << 20;
const LINE_MAX = 64 << 10;
const DISTANCE_MAX = 100;
const RADIUS_MAX = 0.1;
/** For files without radii, m. */
const RADIUS_TYPICAL = 0.008;
const TIME_MAX = 1e7;

export class MotionError extends Error {
  constructor(file: string, line: number, cause: string) {
    super(`${file}, line ${line}: ${cause}`);
  }
}

export function parseMotion(text: string, name: string): Motion {
  const tracks: Record<Side, { times: number[]; samples: Float32Array[] }> = {
    left: { times: [], samples: [] },
    right: { times: [], samples: [] },
  };
  let order: readonly number[] | null = null;
  text.split("\n").forEach((line, index) => {
    if (line.trim() === "") return;
    try {
      if (line.length > LINE_MAX) throw new Error(`longer than ${LINE_MAX} characters`);
      const value = object(line);
      if (order === null) order = readHeader(value);
      else readSample(value, order, tracks);
    } catch (error) {
      throw new MotionError(name, index + 1, error instanceof Error ? error.message : String(error));
    }
  });
  if (order === null) throw new MotionError(name, 1, "the first line must be the header");
  const times = [...tracks.left.times, ...tracks.right.times];
  if (times.length === 0) throw new MotionError(name, 2, "there is no sample after the header");
  const present: Partial<Record<Side, Track>> = {};
  for (const side of ["left", "right"] as const) {
    if (tracks[side].times.length > 0) present[side] = tracks[side];
  }
  const start = times.reduce((a, b) => Math.min(a, b));
  const end = times.reduce((a, b) => Math.max(a, b));
  return { name, tracks: present, start, end };
}

type Fields = Readonly<Record<string, unknown>>;

function object(line: string): Fields {
  let value: unknown;
  try {
    value = JSON.parse(line);
  } catch {
    throw new Error("not JSON");
  }
  if (typeof value !== "object" || value === null || Array.isArray(value)) {
    throw new Error("expected a JSON object");
  }
  return value as Fields;
}

function readHeader(header: Fields): readonly number[] {
  if (header["format"] !== "hand-joints-jsonl" || header["version"] !== 1) {
    throw new Error('header: expected "format":"hand-joints-jsonl" and "version":1');
  }
  if (header["quat"] !== "x,y,z,w") throw new Error('header: "quat" must be "x,y,z,w"');
  const joints = list(header["joints"], "joints", JOINTS);
  return JOINT_NAMES.map((joint) => {
    const place = joints.indexOf(joint);
    if (place < 0) throw new Error(`header: joint "${joint}" is missing`);
    return place;
  });
}

function readSample(
  sample: Fields,
  order: readonly number[],
  tracks: Record<Side, { times: number[]; samples: Float32Array[] }>,
): void {
  const t = number(sample["t"], "t", TIME_MAX);
  const side = sample["hand"];
  if (side !== "left" && side !== "right") throw new Error('"hand" must be "left" or "right"');
  const pos = list(sample["pos"], "pos", JOINTS);
  const quat = list(sample["quat"], "quat", JOINTS);
  const radius = sample["radius"] === undefined ? null : list(sample["radius"], "radius", JOINTS);
  const joints = new Float32Array(JOINTS * JOINT_NUMBERS);
  order.forEach((from, joint) => {
    const at = JOINT_NUMBERS * joint;
    const name = JOINT_NAMES[joint];
    joints.set(numbers(pos[from], `pos of ${name}`, 3, DISTANCE_MAX), at);
    const q = numbers(quat[from], `quat of ${name}`, 4, 2);
    const length = Math.hypot(...q);
    if (length < 0.9 || length > 1.1) {
      throw new Error(`quat of ${name} has length ${length.toPrecision(3)}, expected 1`);
    }
    joints.set(
      q.map((x) => x / length),
      at + 3,
    );
    joints[at + 7] =
      radius === null ? RADIUS_TYPICAL : number(radius[from], `radius of ${name}`, RADIUS_MAX);
    if (joints[at + 7] < 0) throw new Error(`radius of ${name} is negative`);
  });
  const track = tracks[side];
  const last = track.times.length === 0 ? -Infinity : track.times[track.times.length - 1];
  if (t < last) throw new Error(`time of the ${side} hand goes back from ${last} s to ${t} s`);
  if (t === last) {
    // Of two samples at the same time the later line counts.
    track.times.pop();
    track.samples.pop();
  }
  track.times.push(t);
  track.samples.push(joints);
}

function list(value: unknown, what: string, count: number): readonly unknown[] {
  if (!Array.isArray(value) || value.length !== count) {
    const found = Array.isArray(value) ? `${value.length}` : "none";
    throw new Error(`"${what}" must be a list of ${count} entries, found ${found}`);
  }
  return value;
}

function numbers(value: unknown, what: string, count: number, most: number): number[] {
  return list(value, what, count).map((x) => number(x, what, most));
}

function number(value: unknown, what: string, most: number): number {
  if (typeof value !== "number" || !Number.isFinite(value) || Math.abs(value) > most) {
    throw new Error(`"${what}": expected a number of at most ${most}, found ${JSON.stringify(value)}`);
  }
  return value;
}
