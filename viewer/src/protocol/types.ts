// What the live protocol carries, as docs/protocol.md sets it down.
// Metres, newtons, seconds, radians; right-handed world frame, +y up; quaternions x, y, z, w.

export const PROTOCOL_VERSION = 3;

/** Numbers per digit and per hand in `Snapshot.fingers`. */
export const PER_DIGIT = 4;
export const PER_HAND = 6 * PER_DIGIT;

export type Vec3 = readonly [number, number, number];
/** Position then quaternion. */
export type Pose7 = readonly [number, number, number, number, number, number, number];
export type Quat4 = readonly [number, number, number, number];
export type Rgb = readonly [number, number, number];

export type Side = "left" | "right";
export type Digit = "palm" | "thumb" | "index" | "middle" | "ring" | "little";
/** In the order of a snapshot's finger table. */
export const DIGITS: readonly Digit[] = ["palm", "thumb", "index", "middle", "ring", "little"];

/** Triangles whose vertices are weighted sums of one tetrahedron's nodes. */
export interface Surface {
  /** Tetrahedron of each vertex. */
  readonly tets: Uint32Array;
  /** Four weights per vertex. */
  readonly weights: Float32Array;
  readonly triangles: Uint32Array;
  /** Four bytes per vertex, sRGB, or null. */
  readonly colours: Uint8Array | null;
}

export interface RigidMesh {
  /** In the body frame, m. */
  readonly positions: Float32Array;
  readonly triangles: Uint32Array;
  readonly colours: Uint8Array | null;
}

export type ShapeKind =
  | "bone"
  | "plane"
  | "sphere"
  | "capsule"
  | "box"
  | "mesh"
  | "none"
  | "cylinder"
  | "ellipsoid"
  | "cone"
  | "compound";

export interface RigidModel {
  readonly name: string;
  readonly kind: ShapeKind;
  readonly fixed: boolean;
  readonly radius: number | null;
  readonly half_length: number | null;
  readonly half: Vec3 | null;
  readonly pose_BS: Pose7;
  readonly colour: Rgb | null;
  readonly mesh: RigidMesh | null;
  /** Of a compound; their poses are in the body's frame. */
  readonly parts: readonly RigidModel[];
}

/** The skinning target of a node: sum of weight * (bone position + bone rotation * offset). */
export interface Skin {
  /** Two rigids per node. */
  readonly bones: Uint16Array;
  /** Two per node. */
  readonly weights: Float32Array;
  /** Two offsets per node, six numbers. */
  readonly offsets: Float32Array;
}

export interface SoftModel {
  readonly name: string;
  readonly look: "skin" | "bread" | "rubber";
  readonly colour: Rgb | null;
  /** Index into hands. */
  readonly hand: number | null;
  /** First node in a snapshot. */
  readonly node_start: number;
  /** Rest shape, three numbers per node, m. */
  readonly nodes: Float32Array;
  /** Four local nodes each. */
  readonly tets: Uint32Array;
  readonly render: Surface;
  readonly collision: Surface;
  readonly skin: Skin | null;
}

export interface HandBone {
  readonly name: string;
  /** Index in the hand's list. */
  readonly parent: number | null;
  readonly digit: Digit;
  readonly ends_B: readonly [Vec3, Vec3];
  readonly radius: number;
  readonly mass: number;
}

/** One of a hand's 20 joint angles, rad. */
export interface HandAngle {
  readonly joint: string;
  readonly rest: number;
  readonly min: number;
  readonly max: number;
  /** The bone the joint carries, index in the hand's list. */
  readonly bone: number;
  /** Of the joint's frame: the angle is a turn about it, in this sense. */
  readonly axis: "x" | "y";
  readonly sense: number;
  /** Joint frame in the parent bone and in the bone. */
  readonly rotation_PJ: Quat4;
  readonly rotation_BK: Quat4;
}

export interface HandModel {
  readonly name: string;
  /** Null where the model does not say: poses do not move it. */
  readonly side: Side | null;
  readonly soft: number | null;
  /** Wrist to middle fingertip, m. */
  readonly length: number;
  readonly bone_start: number;
  readonly bone_count: number;
  /** First bone in a snapshot's targets. */
  readonly target_start: number;
  readonly bones: readonly HandBone[];
  /** Wrist frame (WebXR: -z towards the fingers, +y out of the back) in the palm bone. */
  readonly wrist_B: Pose7;
  /** Per digit, thumb first: base flexion, base spread, second flexion, third flexion. */
  readonly angles: readonly (HandAngle | null)[];
  /** Named shapes of this hand as such angles; none of a server that does not say. */
  readonly shapes: ReadonlyMap<string, Float64Array>;
  /** Per collision vertex, an index into DIGITS. */
  readonly collision_digits: Uint8Array;
  /** Worn at the wrist, in the palm bone's frame, m; null for hands with a forearm, and where a server does not say. */
  readonly cuff: RigidMesh | null;
}

export interface SceneCamera {
  readonly position: Vec3;
  readonly target: Vec3;
  readonly fov_deg: number;
}

/** Two bodies that the scene starts inside each other. */
export interface Overlap {
  readonly bodies: readonly [string, string];
  /** m */
  readonly depth: number;
  readonly place: Vec3;
}

export interface SceneModel {
  readonly epoch: number;
  readonly scene: string;
  readonly title: string;
  readonly description: string;
  readonly time_step: number;
  readonly duration: number;
  readonly camera: SceneCamera | null;
  readonly rigids: readonly RigidModel[];
  readonly softs: readonly SoftModel[];
  readonly hands: readonly HandModel[];
  /** The deepest first. */
  readonly overlaps: readonly Overlap[];
  /** Sums over the bodies, to check snapshots against. */
  readonly node_count: number;
  readonly target_count: number;
}

/** Bits of `Snapshot.flags`. */
export const FLAG = {
  paused: 1,
  failed: 2,
  slow: 4,
  contactsLeftOut: 8,
  scripted: 16,
  tracked: 32,
} as const;

/** Soft bodies are numbered from here in a contact. */
export const SOFT_BODY = 32768;
/** In place of a collision vertex: the body is rigid. */
export const NO_VERTEX = 65535;

/** Three numbers to be written, such as a Vector3. */
export interface Numbers3 {
  x: number;
  y: number;
  z: number;
}

/** Contacts of one snapshot, read in place. Force is on body A; the normal runs from B to A. */
export interface Contacts {
  readonly count: number;
  bodyA(i: number): number;
  bodyB(i: number): number;
  /** Nearest collision vertex of A, or NO_VERTEX. */
  vertexA(i: number): number;
  vertexB(i: number): number;
  /** Place, m. */
  place(i: number, out: Numbers3): void;
  /** Force on A, N. */
  force(i: number, out: Numbers3): void;
  /** Unit normal from B to A. */
  normal(i: number, out: Numbers3): void;
  /** Part of the force along the normal, N. */
  normalForce(i: number): number;
  /** Surface that it stands for, m²; 0 between rigid bodies. */
  area(i: number): number;
  /** Slip speed, m/s. */
  slip(i: number): number;
  /** Gap, m. */
  gap(i: number): number;
}

export interface Snapshot {
  readonly epoch: number;
  readonly flags: number;
  readonly number: number;
  readonly steps: number;
  /** Simulated, s. */
  readonly time: number;
  /** Cost of the last step, ms. */
  readonly stepCost: number;
  /** What a step may cost, ms. */
  readonly stepBudget: number;
  /** Simulated over real time. */
  readonly speed: number;
  readonly energy: { readonly total: number; readonly kinetic: number; readonly elastic: number };
  /** Deepest penetration, m. */
  readonly penetration: number;
  /** Largest joint gap, m. */
  readonly jointGap: number;
  /** Newest pose message that acted, 0 if none. */
  readonly poseNumber: number;
  readonly sweeps: number;
  /** Seven numbers per rigid body. */
  readonly rigids: Float32Array;
  /** Three numbers per node. */
  readonly nodes: Float32Array;
  /** Seven numbers per tracked bone; NaN where none. */
  readonly targets: Float32Array;
  /** `PER_HAND` numbers: per digit normal force N, shear force N, area m², mean pressure on skin Pa. */
  readonly fingers: Float32Array;
  readonly contacts: Contacts;
  /** Bytes of the message. */
  readonly bytes: number;
  /** `performance.now()` when it came, ms. */
  readonly received: number;
}

export interface SceneEntry {
  readonly name: string;
  readonly title: string;
}

export interface Welcome {
  readonly type: "welcome";
  readonly protocol: number;
  readonly server: string;
  /** This client's number. */
  readonly client: number;
  readonly scenes: readonly SceneEntry[];
}

interface SettingBase {
  readonly key: string;
  readonly label: string;
  readonly help: string;
  readonly group: string;
  readonly unit: string;
}

export interface RangeSetting extends SettingBase {
  readonly value: number;
  /** The scene's own value. */
  readonly own: number;
  readonly min: number;
  readonly max: number;
  readonly scale: "linear" | "log";
}

export interface ChoiceSetting extends SettingBase {
  readonly value: string;
  readonly own: string;
  readonly choices: readonly string[];
}

export type Setting = RangeSetting | ChoiceSetting;

export function isChoice(setting: Setting): setting is ChoiceSetting {
  return "choices" in setting;
}

export type HandsChoice = "scene" | "left" | "right" | "both";

export interface Status {
  readonly type: "status";
  /** The client that holds control, or null. */
  readonly control: number | null;
  readonly viewers: number;
  readonly paused: boolean;
  readonly speed: number;
  readonly scene: string;
  /** What is being loaded, or null. */
  readonly loading: string | null;
  readonly hands: HandsChoice;
  /** What stands in the simulation's way, or null. */
  readonly problem?: string | null;
  readonly settings: readonly Setting[];
  /** The recording that is shown; absent when a scene is live. */
  readonly recording?: Recorded;
}

/** A recording that the server shows. */
export interface Recorded {
  readonly file: string;
  /** Place in it, s. */
  readonly time: number;
  /** Its length, s. */
  readonly end: number;
}

export interface ErrorMessage {
  readonly type: "error";
  readonly message: string;
}

export interface Pong {
  readonly type: "pong";
  readonly t: number;
  /** The server's clock, s. */
  readonly server: number;
}

/** How the devices do that feel the scene. */
export interface Touch {
  readonly type: "touch";
  readonly state: "dry-run" | "waiting" | "ramping" | "live" | "tripped" | "failed";
  /** Why it waits or has stopped. */
  readonly reason: string | null;
  /** The client that must stay for forces to last, or null. */
  readonly armed_by: number | null;
  /** Ticks of the haptic loop per second, wanted. */
  readonly rate: number;
  /** Ticks so far, and deadlines that passed without one. */
  readonly ticks: number;
  readonly missed: number;
  /** 999 of 1000 ticks come within this time of the one before, us. */
  readonly period_p999_us: number;
  readonly devices: readonly {
    /** Its address, such as "lucidgloves:/dev/ttyUSB0". */
    readonly name: string;
    readonly connected: boolean;
    /** Since it last said something that made sense, s; null before the first time. */
    readonly silent_s: number | null;
    /** It tells where hands are. */
    readonly tracks: boolean;
    /** It shows forces. */
    readonly shows: boolean;
  }[];
  readonly hands: readonly {
    readonly side: Side;
    readonly tracked: boolean;
    /** What its display does; null where there is none. */
    readonly renders: "tendons" | "stops" | "vibration" | "wrench" | null;
    /** Largest force that its display may be sent, N. */
    readonly force_max: number;
    /** Forces, thumb first, or x, y, z of a wrench, N. */
    readonly wanted: readonly number[];
    readonly sent: readonly number[];
  }[];
  readonly warnings: readonly string[];
  /** What was told last, the newest at the end. */
  readonly messages: readonly string[];
  /** What arming means. */
  readonly statement: string;
}

export type ServerText = Welcome | Status | ErrorMessage | Pong | Touch;

/** How a hand grips. */
export type GripKind = "pinch" | "tripod" | "power" | "hook" | "lateral";

export type Command =
  | { readonly type: "control"; readonly take: boolean }
  | { readonly type: "run"; readonly paused: boolean }
  | { readonly type: "step" }
  | { readonly type: "reset" }
  | { readonly type: "speed"; readonly value: number }
  | { readonly type: "seek"; readonly time: number }
  | { readonly type: "scene"; readonly name: string }
  | {
      readonly type: "hands";
      readonly which: HandsChoice;
      readonly lengths: { readonly left: number | null; readonly right: number | null };
    }
  | { readonly type: "script" }
  | { readonly type: "grip"; readonly kind?: GripKind; readonly object?: string; readonly force?: number }
  | { readonly type: "release" }
  | { readonly type: "arm"; readonly keep?: boolean }
  | { readonly type: "hold" }
  | { readonly type: "stop" }
  | { readonly type: "set"; readonly key: string; readonly value: number | string }
  | { readonly type: "ping"; readonly t: number };
