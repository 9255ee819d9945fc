// The model message: JSON that names arrays in the block behind it.

import { check } from "./check";
import {
  DIGITS,
  type HandAngle,
  type HandBone,
  type HandModel,
  type Overlap,
  type Pose7,
  type Quat4,
  type Rgb,
  type RigidMesh,
  type RigidModel,
  type SceneModel,
  type ShapeKind,
  type Skin,
  type SoftModel,
  type Surface,
  type Vec3,
} from "./types";

type Json = { readonly [key: string]: unknown };

const SHAPES: readonly ShapeKind[] = [
  "bone",
  "plane",
  "sphere",
  "capsule",
  "box",
  "mesh",
  "none",
  "cylinder",
  "ellipsoid",
  "cone",
  "compound",
];
const LOOKS = ["skin", "bread", "rubber"] as const;
const SIDES = ["left", "right"] as const;
const TYPES = { f32: Float32Array, u32: Uint32Array, u16: Uint16Array, u8: Uint8Array };
type ArrayOf = { f32: Float32Array; u32: Uint32Array; u16: Uint16Array; u8: Uint8Array };

function object(value: unknown, what: string): Json {
  check(typeof value === "object" && value !== null && !Array.isArray(value), `${what} is no object.`);
  return value as Json;
}

function list(value: unknown, what: string): readonly unknown[] {
  check(Array.isArray(value), `${what} is no list.`);
  return value;
}

function text(value: unknown, what: string): string {
  check(typeof value === "string", `${what} is no text.`);
  return value;
}

function number(value: unknown, what: string): number {
  check(typeof value === "number" && Number.isFinite(value), `${what} is not a number.`);
  return value;
}

function index(value: unknown, end: number, what: string): number {
  const n = number(value, what);
  check(Number.isInteger(n) && n >= 0 && n < end, `${what} is ${n}, of ${end}.`);
  return n;
}

function oneOf<T extends string>(value: unknown, choices: readonly T[], what: string): T {
  const found = choices.find((choice) => choice === value);
  check(found !== undefined, `${what} is "${String(value)}".`);
  return found;
}

function orNull<T>(value: unknown, read: (value: unknown) => T): T | null {
  return value === null || value === undefined ? null : read(value);
}

function numbers(value: unknown, count: number, what: string): number[] {
  const items = list(value, what);
  check(items.length === count, `${what} has ${items.length} numbers instead of ${count}.`);
  return items.map((item) => number(item, what));
}

const vec3 = (value: unknown, what: string) => numbers(value, 3, what) as unknown as Vec3;
const pose = (value: unknown, what: string) => numbers(value, 7, what) as unknown as Pose7;
const quat = (value: unknown, what: string) => numbers(value, 4, what) as unknown as Quat4;
const rgb = (value: unknown, what: string) => numbers(value, 3, what) as unknown as Rgb;

/** The arrays behind the JSON. */
class Arrays {
  constructor(
    private readonly bytes: ArrayBuffer,
    private readonly start: number,
  ) {}

  get<K extends keyof ArrayOf>(value: unknown, type: K, width: number, what: string): ArrayOf[K] {
    const entry = object(value, what);
    check(entry["type"] === type && entry["width"] === width, `${what} is not ${type} × ${width}.`);
    const offset = number(entry["offset"], what);
    const count = number(entry["count"], what);
    const size = TYPES[type].BYTES_PER_ELEMENT;
    const length = count * width;
    const whole = Number.isInteger(offset) && Number.isInteger(count) && offset >= 0 && count >= 0;
    check(whole && offset % 4 === 0, `${what} has no sound place.`);
    check(this.start + offset + length * size <= this.bytes.byteLength, `${what} is cut off.`);
    return new TYPES[type](this.bytes, this.start + offset, length) as ArrayOf[K];
  }
}

function checkBelow(values: Uint32Array | Uint16Array, end: number, what: string): void {
  for (let i = 0; i < values.length; i++) {
    if (values[i] >= end) check(false, `${what} names ${values[i]}, of ${end}.`);
  }
}

function readColours(value: unknown, vertices: number, arrays: Arrays, what: string) {
  const colours = orNull(value, (v) => arrays.get(v, "u8", 4, what));
  check(colours === null || colours.length === 4 * vertices, `${what} are not one per vertex.`);
  return colours;
}

function readSurface(value: unknown, tetCount: number, arrays: Arrays, what: string): Surface {
  const json = object(value, what);
  const tets = arrays.get(json["tets"], "u32", 1, `${what}.tets`);
  const weights = arrays.get(json["weights"], "f32", 4, `${what}.weights`);
  const triangles = arrays.get(json["triangles"], "u32", 3, `${what}.triangles`);
  check(weights.length === 4 * tets.length, `${what}.weights are not one per vertex.`);
  checkBelow(tets, tetCount, `${what}.tets`);
  checkBelow(triangles, tets.length, `${what}.triangles`);
  const colours = readColours(json["colours"], tets.length, arrays, `${what}.colours`);
  return { tets, weights, triangles, colours };
}

function readMesh(value: unknown, arrays: Arrays, what: string): RigidMesh {
  const json = object(value, what);
  const positions = arrays.get(json["positions"], "f32", 3, `${what}.positions`);
  const triangles = arrays.get(json["triangles"], "u32", 3, `${what}.triangles`);
  checkBelow(triangles, positions.length / 3, `${what}.triangles`);
  const colours = readColours(json["colours"], positions.length / 3, arrays, `${what}.colours`);
  return { positions, triangles, colours };
}

function readRigid(value: unknown, what: string, arrays: Arrays): RigidModel {
  const json = object(value, what);
  const size = (key: string) => orNull(json[key], (v) => number(v, `${what}.${key}`));
  return {
    name: text(json["name"], `${what}.name`),
    kind: oneOf(json["kind"], SHAPES, `${what}.kind`),
    fixed: json["fixed"] === true,
    radius: size("radius"),
    half_length: size("half_length"),
    half: orNull(json["half"], (v) => vec3(v, `${what}.half`)),
    pose_BS: orNull(json["pose_BS"], (v) => pose(v, `${what}.pose_BS`)) ?? [0, 0, 0, 0, 0, 0, 1],
    colour: orNull(json["colour"], (v) => rgb(v, `${what}.colour`)),
    mesh: orNull(json["mesh"], (v) => readMesh(v, arrays, `${what}.mesh`)),
    parts: list(json["parts"] ?? [], `${what}.parts`).map((v, k) =>
      readRigid(v, `${what}.parts[${k}]`, arrays),
    ),
  };
}

function readSkin(value: unknown, nodes: number, rigids: number, arrays: Arrays, what: string): Skin {
  const json = object(value, what);
  const bones = arrays.get(json["bones"], "u16", 2, `${what}.bones`);
  const weights = arrays.get(json["weights"], "f32", 2, `${what}.weights`);
  const offsets = arrays.get(json["offsets"], "f32", 6, `${what}.offsets`);
  const whole = bones.length === 2 * nodes && weights.length === 2 * nodes && offsets.length === 6 * nodes;
  check(whole, `${what} is not one per node.`);
  checkBelow(bones, rigids, `${what}.bones`);
  return { bones, weights, offsets };
}

function readSoft(value: unknown, i: number, rigids: number, hands: number, arrays: Arrays): SoftModel {
  const what = `softs[${i}]`;
  const json = object(value, what);
  const nodes = arrays.get(json["nodes"], "f32", 3, `${what}.nodes`);
  const count = nodes.length / 3;
  const tets = arrays.get(json["tets"], "u32", 4, `${what}.tets`);
  checkBelow(tets, count, `${what}.tets`);
  return {
    name: text(json["name"], `${what}.name`),
    look: oneOf(json["look"], LOOKS, `${what}.look`),
    colour: orNull(json["colour"], (v) => rgb(v, `${what}.colour`)),
    hand: orNull(json["hand"], (v) => index(v, hands, `${what}.hand`)),
    node_start: number(json["node_start"], `${what}.node_start`),
    nodes,
    tets,
    render: readSurface(json["render"], tets.length / 4, arrays, `${what}.render`),
    collision: readSurface(json["collision"], tets.length / 4, arrays, `${what}.collision`),
    skin: orNull(json["skin"], (v) => readSkin(v, count, rigids, arrays, `${what}.skin`)),
  };
}

function readBone(value: unknown, count: number, what: string): HandBone {
  const json = object(value, what);
  const ends = list(json["ends_B"], `${what}.ends_B`);
  return {
    name: text(json["name"], `${what}.name`),
    parent: orNull(json["parent"], (v) => index(v, count, `${what}.parent`)),
    digit: oneOf(json["digit"], DIGITS, `${what}.digit`),
    ends_B: [vec3(ends[0], `${what}.ends_B`), vec3(ends[1], `${what}.ends_B`)],
    radius: number(json["radius"], `${what}.radius`),
    mass: number(json["mass"], `${what}.mass`),
  };
}

function readAngle(value: unknown, bones: number, what: string): HandAngle {
  const json = object(value, what);
  return {
    joint: text(json["joint"], `${what}.joint`),
    rest: number(json["rest"], `${what}.rest`),
    min: number(json["min"], `${what}.min`),
    max: number(json["max"], `${what}.max`),
    bone: index(json["bone"], bones, `${what}.bone`),
    axis: oneOf(json["axis"], ["x", "y"] as const, `${what}.axis`),
    sense: number(json["sense"], `${what}.sense`),
    rotation_PJ: quat(json["rotation_PJ"], `${what}.rotation_PJ`),
    rotation_BK: quat(json["rotation_BK"], `${what}.rotation_BK`),
  };
}

function readHand(value: unknown, i: number, rigids: number, softs: number, arrays: Arrays): HandModel {
  const what = `hands[${i}]`;
  const json = object(value, what);
  const bones = list(json["bones"], `${what}.bones`);
  const start = index(json["bone_start"], rigids, `${what}.bone_start`);
  const count = number(json["bone_count"], `${what}.bone_count`);
  check(bones.length === count && start + count <= rigids, `${what} counts bones wrongly.`);
  const angles = list(json["angles"], `${what}.angles`);
  check(angles.length === 20, `${what}.angles has ${angles.length} entries instead of 20.`);
  return {
    name: text(json["name"], `${what}.name`),
    side: orNull(json["side"], (v) => oneOf(v, SIDES, `${what}.side`)),
    soft: orNull(json["soft"], (v) => index(v, softs, `${what}.soft`)),
    length: number(json["length"], `${what}.length`),
    bone_start: start,
    bone_count: count,
    target_start: number(json["target_start"], `${what}.target_start`),
    bones: bones.map((bone, b) => readBone(bone, count, `${what}.bones[${b}]`)),
    wrist_B: pose(json["wrist_B"], `${what}.wrist_B`),
    angles: angles.map((angle, a) => orNull(angle, (v) => readAngle(v, count, `${what}.angles[${a}]`))),
    shapes: readShapes(json["shapes"] ?? {}, `${what}.shapes`),
    collision_digits: arrays.get(json["collision_digits"], "u8", 1, `${what}.collision_digits`),
    cuff: orNull(json["cuff"] ?? null, (v) => readMesh(v, arrays, `${what}.cuff`)),
  };
}

function readShapes(value: unknown, what: string): ReadonlyMap<string, Float64Array> {
  return new Map(
    Object.entries(object(value, what)).map(([name, of]) => {
      const angles = list(of, `${what}.${name}`).map((angle) => number(angle, `${what}.${name}`));
      check(angles.length === 20, `${what}.${name} has ${angles.length} entries instead of 20.`);
      return [name, Float64Array.from(angles)];
    }),
  );
}

function readOverlap(value: unknown, i: number): Overlap {
  const what = `overlaps[${i}]`;
  const json = object(value, what);
  const bodies = list(json["bodies"], `${what}.bodies`).map((name) => text(name, `${what}.bodies`));
  check(bodies.length === 2, `${what} has ${bodies.length} bodies instead of 2.`);
  return {
    bodies: [bodies[0], bodies[1]],
    depth: number(json["depth"], `${what}.depth`),
    place: vec3(json["place"], `${what}.place`),
  };
}

export function decodeModel(bytes: ArrayBuffer, epoch: number): SceneModel {
  check(bytes.byteLength >= 16, `A model of ${bytes.byteLength} bytes is cut off.`);
  const length = new DataView(bytes).getUint32(8, true);
  const sound = length % 4 === 0 && 16 + length <= bytes.byteLength;
  check(sound, `A model of ${bytes.byteLength} bytes with ${length} bytes of JSON.`);
  const json = object(parse(bytes, length), "The model");
  const arrays = new Arrays(bytes, 16 + length);

  const rigidList = list(json["rigids"], "rigids");
  const softList = list(json["softs"], "softs");
  const handList = list(json["hands"], "hands");
  const [R, S, H] = [rigidList.length, softList.length, handList.length];
  const rigids = rigidList.map((v, i) => readRigid(v, `rigids[${i}]`, arrays));
  const softs = softList.map((v, i) => readSoft(v, i, R, H, arrays));
  const hands = handList.map((v, i) => readHand(v, i, R, S, arrays));

  // Bodies lie one after the other in snapshots.
  let node_count = 0;
  for (const soft of softs) {
    check(soft.node_start === node_count, `${soft.name} starts at node ${soft.node_start}.`);
    node_count += soft.nodes.length / 3;
  }
  let target_count = 0;
  for (const hand of hands) {
    check(hand.target_start === target_count, `${hand.name} starts at target ${hand.target_start}.`);
    target_count += hand.bone_count;
    const vertices = hand.soft === null ? 0 : softs[hand.soft].collision.tets.length;
    check(hand.collision_digits.length === vertices, `${hand.name} numbers digits wrongly.`);
  }

  return {
    epoch,
    scene: text(json["scene"], "scene"),
    title: text(json["title"], "title"),
    description: text(json["description"], "description"),
    time_step: number(json["time_step"], "time_step"),
    duration: number(json["duration"], "duration"),
    camera: orNull(json["camera"], (v) => {
      const camera = object(v, "camera");
      return {
        position: vec3(camera["position"], "camera.position"),
        target: vec3(camera["target"], "camera.target"),
        fov_deg: number(camera["fov_deg"], "camera.fov_deg"),
      };
    }),
    rigids,
    softs,
    hands,
    // Page recordings of protocol 1 have none.
    overlaps: list(json["overlaps"] ?? [], "overlaps").map(readOverlap),
    node_count,
    target_count,
  };
}

function parse(bytes: ArrayBuffer, length: number): unknown {
  try {
    return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(new Uint8Array(bytes, 16, length)));
  } catch {
    check(false, "The model's JSON does not parse.");
  }
}
