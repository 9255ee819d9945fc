// A little encoder of models and snapshots, written from docs/protocol.md alone, and a small world:
// a table, a two-bone hand with flesh of two tetrahedra, a ball.

export interface ArrayRef {
  offset: number;
  count: number;
  type: "f32" | "u32" | "u16" | "u8";
  width: number;
}

export class Arrays {
  private readonly bytes: number[] = [];

  put(type: ArrayRef["type"], width: number, numbers: readonly number[]): ArrayRef {
    while (this.bytes.length % 4 !== 0) this.bytes.push(0);
    const offset = this.bytes.length;
    const size = { f32: 4, u32: 4, u16: 2, u8: 1 }[type];
    for (const x of numbers) {
      const view = new DataView(new ArrayBuffer(4));
      if (type === "f32") view.setFloat32(0, x, true);
      else view.setUint32(0, x, true);
      for (let k = 0; k < size; k++) this.bytes.push(view.getUint8(k));
    }
    return { offset, count: numbers.length / width, type, width };
  }

  all(): readonly number[] {
    return this.bytes;
  }
}

export function encodeModel(json: object, arrays: Arrays, epoch: number): ArrayBuffer {
  let text = JSON.stringify(json);
  while (new TextEncoder().encode(text).length % 4 !== 0) text += " ";
  const body = new TextEncoder().encode(text);
  const out = new Uint8Array(16 + body.length + arrays.all().length);
  const view = new DataView(out.buffer);
  out[0] = 1;
  out[1] = 3;
  view.setUint32(4, epoch, true);
  view.setUint32(8, body.length, true);
  out.set(body, 16);
  out.set(arrays.all(), 16 + body.length);
  return out.buffer;
}

/** Five nodes: two tetrahedra that share a face. */
export const NODES = [0, 0, 0, 0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01, 0.01, 0.01, 0.01];
export const TETS = [0, 1, 2, 3, 1, 2, 3, 4];

export function worldJson(arrays: Arrays) {
  const surface = () => ({
    tets: arrays.put("u32", 1, [0, 0, 0, 1]),
    weights: arrays.put("f32", 4, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
    triangles: arrays.put("u32", 3, [0, 1, 2, 1, 3, 2]),
    colours: arrays.put("u8", 4, [1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 255, 10, 11, 12, 255]),
  });
  const bone = (name: string, parent: number | null, digit: string) => ({
    name,
    parent,
    digit,
    ends_B: [
      [0, 0, 0.01],
      [0, 0, -0.01],
    ],
    radius: 0.004,
    mass: 0.05,
  });
  const rigid = (name: string, kind: string, more: object = {}) => ({
    name,
    kind,
    fixed: false,
    pose_BS: [0, 0, 0, 0, 0, 0, 1],
    colour: null,
    mesh: null,
    ...more,
  });
  return {
    scene: "test",
    title: "A test",
    description: "Umlaut: ü",
    time_step: 0.005,
    duration: 2,
    camera: { position: [0, 0.2, 0.4], target: [0, 0, 0], fov_deg: 30 },
    rigids: [
      rigid("table", "plane", { fixed: true }),
      rigid("palm", "bone"),
      rigid("tip", "bone"),
      rigid("ball", "sphere", { radius: 0.02, colour: [1, 0, 0] }),
    ],
    softs: [
      {
        name: "flesh",
        look: "skin",
        colour: null,
        hand: 0,
        node_start: 0,
        nodes: arrays.put("f32", 3, NODES),
        tets: arrays.put("u32", 4, TETS),
        render: surface(),
        collision: surface(),
        skin: {
          bones: arrays.put("u16", 2, [1, 1, 1, 2, 1, 2, 1, 2, 2, 2]),
          weights: arrays.put("f32", 2, [1, 0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 1, 0]),
          offsets: arrays.put(
            "f32",
            6,
            Array.from({ length: 30 }, (_, i) => NODES[3 * Math.floor(i / 6) + (i % 3)]),
          ),
        },
      },
    ],
    hands: [
      {
        name: "hand",
        side: "right",
        soft: 0,
        length: 0.19,
        bone_start: 1,
        bone_count: 2,
        target_start: 0,
        bones: [bone("palm", null, "palm"), bone("index-distal", 0, "index")],
        wrist_B: [0, 0, 0, 0, 0, 0, 1],
        angles: Array.from({ length: 20 }, (_, i) => (i === 4 ? ANGLE : null)),
        shapes: { fist: Array.from({ length: 20 }, (_, i) => i / 10) },
        collision_digits: arrays.put("u8", 1, [0, 0, 2, 2]),
        cuff: {
          positions: arrays.put("f32", 3, [0, 0, 0, 1, 0, 0, 0, 1, 0]),
          triangles: arrays.put("u32", 3, [0, 1, 2]),
          colours: null,
        },
      },
    ],
  };
}

export function encodeWorld(epoch = 1): ArrayBuffer {
  const arrays = new Arrays();
  return encodeModel(worldJson(arrays), arrays, epoch);
}

export interface TestContact {
  readonly bodies: readonly [number, number];
  readonly vertices: readonly [number, number];
  /** Place, force, anything, area, slip, gap. */
  readonly numbers: readonly number[];
  /** As it is sent: two numbers of 16 bits. */
  readonly normal: readonly [number, number];
}

const ANGLE = {
  joint: "j",
  rest: 0,
  min: -1,
  max: 1,
  bone: 0,
  axis: "x",
  sense: 1,
  rotation_PJ: [0, 0, 0, 1],
  rotation_BK: [0, 0, 0, 1],
};

/** A snapshot of that world: bodies at rest, all nodes moved up by `rise`. */
export function encodeSnapshot(
  epoch: number,
  rise: number,
  contacts: readonly TestContact[] = [],
): ArrayBuffer {
  const floats = [
    ...[0, 1, 2, 3].flatMap((i) => [0.1 * i, rise, 0, 0, 0, 0, 1]),
    ...NODES.map((x, i) => x + (i % 3 === 1 ? rise : 0)),
    ...Array.from({ length: 14 }, () => NaN),
    ...Array.from({ length: 24 }, (_, i) => i),
  ];
  const out = new DataView(new ArrayBuffer(88 + 4 * floats.length + 48 * contacts.length));
  out.setUint8(0, 2);
  out.setUint8(1, 3);
  out.setUint16(2, 16, true);
  out.setUint32(4, epoch, true);
  out.setUint32(8, 7, true);
  out.setUint32(12, 400, true);
  out.setFloat64(16, 2.5, true);
  [1.5, 5, 0.75, 3, 1, 2, 0.001, 0.002].forEach((x, i) => out.setFloat32(24 + 4 * i, x, true));
  out.setUint32(56, 99, true);
  out.setUint32(60, 12, true);
  [4, 5, 2, contacts.length, 1].forEach((x, i) => out.setUint32(64 + 4 * i, x, true));
  floats.forEach((x, i) => out.setFloat32(88 + 4 * i, x, true));
  contacts.forEach(({ bodies, vertices, numbers, normal }, i) => {
    const at = 88 + 4 * floats.length + 48 * i;
    [...bodies, ...vertices].forEach((x, k) => out.setUint16(at + 2 * k, x, true));
    numbers.forEach((x, k) => out.setFloat32(at + 8 + 4 * k, x, true));
    normal.forEach((x, k) => out.setInt16(at + 32 + 2 * k, x, true));
  });
  return out.buffer;
}
