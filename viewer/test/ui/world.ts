// A small world written as the server writes it (docs/protocol.md): one right hand of 16 bones,
// a fixed table and a box, no flesh. The bones hang together as joints would have them.

import { Quaternion, Vector3 } from "three";

/** Angles in the order of `hands[].angles`, rad. */
export interface Place {
  readonly position: Vector3;
  readonly rotation: Quaternion;
  readonly angles: ArrayLike<number>;
}

const DIGITS = ["thumb", "index", "middle", "ring", "little"] as const;
/** Place of the base joint in the wrist frame of a right hand and lengths of the bones, m. */
const GEOMETRY = {
  thumb: { base: [-0.025, -0.01, -0.03], lengths: [0.033, 0.034, 0.026] },
  index: { base: [-0.025, 0, -0.095], lengths: [0.045, 0.024, 0.022] },
  middle: { base: [0, 0, -0.095], lengths: [0.047, 0.028, 0.022] },
  ring: { base: [0.018, 0, -0.088], lengths: [0.043, 0.027, 0.022] },
  little: { base: [0.036, 0, -0.08], lengths: [0.035, 0.02, 0.021] },
} as const;
/** The thumb points out to the side. */
const THUMB_TURN = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), 0.7);
const X = new Vector3(1, 0, 0);
const Y = new Vector3(0, 1, 0);

/** Poses of the 16 bones: frames at their near end, -z along them. */
export function forward(place: Place): { position: Vector3; rotation: Quaternion }[] {
  const bones = [{ position: place.position.clone(), rotation: place.rotation.clone() }];
  DIGITS.forEach((digit, d) => {
    const { base, lengths } = GEOMETRY[digit];
    const position = new Vector3(...base).applyQuaternion(place.rotation).add(place.position);
    const rotation = place.rotation.clone();
    if (digit === "thumb") rotation.multiply(THUMB_TURN);
    // Spread is away from the middle finger; a turn about +y moves a finger towards -x, the thumb.
    const out = d <= 2 ? 1 : -1;
    rotation.multiply(new Quaternion().setFromAxisAngle(Y, out * place.angles[4 * d + 1]));
    [0, 2, 3].forEach((k, segment) => {
      rotation.multiply(new Quaternion().setFromAxisAngle(X, -place.angles[4 * d + k]));
      bones.push({ position: position.clone(), rotation: rotation.clone() });
      position.add(new Vector3(0, 0, -lengths[segment]).applyQuaternion(rotation));
    });
  });
  return bones;
}

function bone(name: string, parent: number | null, digit: string, length: number) {
  return {
    name,
    parent,
    digit,
    ends_B: [
      [0, 0, 0],
      [0, 0, -length],
    ],
    radius: 0.005,
    mass: 0.01,
  };
}

export function modelMessage(epoch = 1, scene = "bread-grasp"): ArrayBuffer {
  const bones = [bone("palm", null, "palm", 0.09)];
  DIGITS.forEach((digit) => {
    GEOMETRY[digit].lengths.forEach((length, k) => {
      bones.push(bone(`${digit}-${k}`, k === 0 ? 0 : bones.length - 1, digit, length));
    });
  });
  const rigid = (name: string, kind: string, more: object) => ({
    name,
    kind,
    fixed: kind === "plane",
    radius: null,
    half_length: null,
    half: null,
    pose_BS: [0, 0, 0, 0, 0, 0, 1],
    colour: null,
    mesh: null,
    ...more,
  });
  const angle = (d: number, place: number, axis: "x" | "y", sense: number, min: number, max: number) => {
    const start = d === 0 && place === 0 ? THUMB_TURN.toArray() : [0, 0, 0, 1];
    const joint = `${DIGITS[d]}-${place}`;
    const frames = { rotation_PJ: start, rotation_BK: [0, 0, 0, 1] };
    return { joint, rest: 0, min, max, bone: 1 + 3 * d + place, axis, sense, ...frames };
  };
  const json = {
    scene,
    title: "A hand grasps a small loaf of bread and lifts it.",
    description: "Flesh and bread give way to each other.",
    time_step: 1 / 60,
    duration: 4.5,
    camera: { position: [-0.36, 0.21, 0.33], target: [0.02, 0.085, 0.02], fov_deg: 34 },
    rigids: [
      ...bones.map(({ name, ends_B, radius }) =>
        rigid(name, "bone", { radius, half_length: -0.5 * ends_B[1][2] }),
      ),
      rigid("table", "plane", {}),
      rigid("box", "box", { half: [0.03, 0.02, 0.03], colour: [0.7, 0.5, 0.3] }),
    ],
    softs: [],
    hands: [
      {
        name: "hand",
        side: "right",
        soft: null,
        length: 0.19,
        bone_start: 0,
        bone_count: 16,
        target_start: 0,
        bones,
        wrist_B: [0, 0, 0, 0, 0, 0, 1],
        angles: DIGITS.flatMap((_, d) => [
          angle(d, 0, "x", -1, -0.8, 1.6),
          angle(d, 0, "y", d <= 2 ? 1 : -1, -0.35, 0.5),
          angle(d, 1, "x", -1, -0.2, 1.75),
          angle(d, 2, "x", -1, -0.1, 1.5),
        ]),
        collision_digits: { offset: 0, count: 0, type: "u8", width: 1 },
      },
    ],
  };
  let text = JSON.stringify(json);
  text += " ".repeat((4 - (new TextEncoder().encode(text).length % 4)) % 4);
  const bytes = new TextEncoder().encode(text);
  const message = new ArrayBuffer(16 + bytes.length);
  const view = new DataView(message);
  view.setUint8(0, 1);
  view.setUint8(1, 3);
  view.setUint32(4, epoch, true);
  view.setUint32(8, bytes.length, true);
  new Uint8Array(message, 16).set(bytes);
  return message;
}

export interface Instant {
  readonly epoch?: number;
  readonly number?: number;
  readonly time?: number;
  readonly flags?: number;
  readonly place: Place;
  /** 24 numbers. */
  readonly fingers?: ArrayLike<number>;
  /** NaN in place of tracked poses. */
  readonly untracked?: boolean;
  readonly poseNumber?: number;
}

export function snapshotMessage(instant: Instant): ArrayBuffer {
  const bones = forward(instant.place);
  const words = 7 * 18 + 7 * 16 + 24;
  const message = new ArrayBuffer(88 + 4 * words);
  const view = new DataView(message);
  view.setUint8(0, 2);
  view.setUint8(1, 3);
  view.setUint16(2, instant.flags ?? 0, true);
  view.setUint32(4, instant.epoch ?? 1, true);
  view.setUint32(8, instant.number ?? 1, true);
  view.setUint32(12, instant.number ?? 1, true);
  view.setFloat64(16, instant.time ?? 0, true);
  [8.5, 16.7, 1, 0.3, 0.1, 0.2, 0.0004, 0.00002].forEach((x, i) => view.setFloat32(24 + 4 * i, x, true));
  view.setUint32(56, instant.poseNumber ?? 0, true);
  view.setUint32(60, 12, true);
  [18, 0, 16, 0, 1].forEach((x, i) => view.setUint32(64 + 4 * i, x, true));
  const numbers = new Float32Array(message, 88);
  const put = (at: number, { position: p, rotation: q }: { position: Vector3; rotation: Quaternion }) =>
    numbers.set([p.x, p.y, p.z, q.x, q.y, q.z, q.w], at);
  bones.forEach((pose, i) => put(7 * i, pose));
  put(7 * 16, { position: new Vector3(), rotation: new Quaternion() });
  put(7 * 17, { position: new Vector3(0, 0.02, 0), rotation: new Quaternion() });
  const targets = 7 * 18;
  bones.forEach((pose, i) => put(targets + 7 * i, pose));
  if (instant.untracked === true) numbers.fill(NaN, targets, targets + 7 * 16);
  numbers.set(
    Array.from({ length: 24 }, (_, i) => instant.fingers?.[i] ?? 0),
    targets + 7 * 16,
  );
  return message;
}
