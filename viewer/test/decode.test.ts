// Models and snapshots, as an encoder that knows only docs/protocol.md writes them.

import { Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { ProtocolError } from "../src/protocol/check";
import { decode } from "../src/protocol/decode";
import { decodeText } from "../src/protocol/text";
import type { SceneModel, Snapshot } from "../src/protocol/types";
import { Arrays, encodeModel, encodeSnapshot, encodeWorld, worldJson } from "./encode-world";

function model(epoch = 1): SceneModel {
  const message = decode(encodeWorld(epoch), null, 0);
  if (message.kind !== "model") throw new Error(message.kind);
  return message.model;
}

function snapshot(bytes: ArrayBuffer, of = model()): Snapshot {
  const message = decode(bytes, of, 12.5);
  if (message.kind !== "snapshot") throw new Error(message.kind);
  return message.snapshot;
}

const CONTACT = {
  bodies: [32768, 0],
  vertices: [2, 65535],
  numbers: [0.1, 0.2, 0.3, 1, 2, 2, 0, 4e-6, 0.01, -1e-4],
  // (1, 2, -2) / 3 by hand: (0.2, 0.4) folded to (1 - 0.4, 1 - 0.2).
  normal: [19660, 26214],
} as const;

describe("a model", () => {
  it("comes with its texts, bodies and arrays", () => {
    const m = model(5);
    expect([m.epoch, m.scene, m.description, m.time_step]).toEqual([5, "test", "Umlaut: ü", 0.005]);
    expect(m.rigids.map((rigid) => rigid.kind)).toEqual(["plane", "bone", "bone", "sphere"]);
    expect(m.rigids[3].radius).toBe(0.02);
    expect([m.node_count, m.target_count]).toEqual([5, 2]);
    expect(Array.from(m.softs[0].tets)).toEqual([0, 1, 2, 3, 1, 2, 3, 4]);
    expect(m.softs[0].render.colours?.[4]).toBe(4);
    expect(Array.from(m.softs[0].skin?.bones ?? [])).toEqual([1, 1, 1, 2, 1, 2, 1, 2, 2, 2]);
    expect(m.hands[0].angles[4]?.joint).toBe("j");
    expect(m.hands[0].angles[3]).toBeNull();
    expect(m.hands[0].shapes.get("fist")?.[19]).toBeCloseTo(1.9, 12);
    expect(m.hands[0].cuff?.triangles).toEqual(Uint32Array.from([0, 1, 2]));
    expect(Array.from(m.hands[0].collision_digits)).toEqual([0, 0, 2, 2]);
  });

  it("may have a hand whose side nobody knows", () => {
    const arrays = new Arrays();
    const json = worldJson(arrays);
    const sideless = { ...json, hands: json.hands.map((hand) => ({ ...hand, side: null })) };
    const message = decode(encodeModel(sideless, arrays, 1), null, 0);
    expect(message.kind === "model" && message.model.hands[0].side).toBeNull();
  });

  it("is refused when cut off anywhere", () => {
    const whole = encodeWorld();
    for (let length = 0; length < whole.byteLength - 3; length += 7) {
      expect(() => decode(whole.slice(0, length), null, 0), `${length} bytes`).toThrow(ProtocolError);
    }
  });

  it("is refused when an index leads outside", () => {
    const refused = (spoil: (json: ReturnType<typeof worldJson>, arrays: Arrays) => void, why: RegExp) => {
      const arrays = new Arrays();
      const json = worldJson(arrays);
      spoil(json, arrays);
      expect(() => decode(encodeModel(json, arrays, 1), null, 0)).toThrow(why);
    };
    refused((json, a) => (json.softs[0].tets = a.put("u32", 4, [0, 1, 2, 3, 1, 2, 3, 5])), /names 5, of 5/);
    refused((json, a) => (json.softs[0].render.triangles = a.put("u32", 3, [0, 1, 4])), /names 4, of 4/);
    refused((json) => (json.softs[0].hand = 1), /is 1, of 1/);
    refused((json) => (json.hands[0].bone_count = 3), /counts bones wrongly/);
    refused((json) => (json.softs[0].node_start = 1), /starts at node 1/);
    refused((json) => (json.softs[0].nodes.count = 1e9), /cut off/);
    refused((json) => (json.softs[0].nodes.offset = 2), /no sound place/);
    refused((json) => (json.rigids[3].kind = "torus"), /"torus"/);
  });
});

describe("a snapshot", () => {
  it("comes with every number in its place", () => {
    const s = snapshot(encodeSnapshot(1, 0.5, [CONTACT]));
    expect([s.flags, s.number, s.steps, s.time]).toEqual([16, 7, 400, 2.5]);
    expect([s.stepCost, s.stepBudget, s.speed]).toEqual([1.5, 5, 0.75]);
    expect(s.energy).toEqual({ total: 3, kinetic: 1, elastic: 2 });
    expect([s.penetration, s.jointGap]).toEqual([Math.fround(0.001), Math.fround(0.002)]);
    expect([s.poseNumber, s.sweeps, s.received]).toEqual([99, 12, 12.5]);
    expect(Array.from(s.rigids.slice(21, 24))).toEqual([Math.fround(0.3), 0.5, 0]);
    expect(Array.from(s.nodes.slice(3, 6))).toEqual([Math.fround(0.01), 0.5, 0]);
    expect(s.targets.every(Number.isNaN)).toBe(true);
    expect(s.fingers[23]).toBe(23);
    const c = s.contacts;
    expect([c.count, c.bodyA(0), c.bodyB(0), c.vertexA(0), c.vertexB(0)]).toEqual([1, 32768, 0, 2, 65535]);
    const [place, force, normal] = [new Vector3(), new Vector3(), new Vector3()];
    c.place(0, place);
    c.force(0, force);
    c.normal(0, normal);
    expect(place.toArray()).toEqual([0.1, 0.2, 0.3].map(Math.fround));
    expect(force.toArray()).toEqual([1, 2, 2]);
    expect(normal.distanceTo(new Vector3(1, 2, -2).divideScalar(3))).toBeLessThan(1e-4);
    expect(c.normalForce(0)).toBeCloseTo(1 / 3, 3);
    expect([c.area(0), c.slip(0), c.gap(0)]).toEqual([4e-6, 0.01, -1e-4].map(Math.fround));
  });

  it("tells normals in any direction", () => {
    const axes: [[number, number], number[]][] = [
      [[32767, 0], [1, 0, 0]],
      [[-32767, 0], [-1, 0, 0]],
      [[0, 32767], [0, 1, 0]],
      [[0, -32767], [0, -1, 0]],
      [[0, 0], [0, 0, 1]],
      [[32767, 32767], [0, 0, -1]],
      [[-32767, 32767], [0, 0, -1]],
      [[-19660, 26214], [-1 / 3, 2 / 3, -2 / 3]],
      [[19660, -26214], [1 / 3, -2 / 3, -2 / 3]],
      [[-6553, -13107], [-1 / 3, -2 / 3, 2 / 3]],
    ];
    for (const [sent, meant] of axes) {
      const normal = new Vector3();
      snapshot(encodeSnapshot(1, 0.5, [{ ...CONTACT, normal: sent }])).contacts.normal(0, normal);
      expect(normal.distanceTo(new Vector3(...meant)), String(sent)).toBeLessThan(1e-4);
    }
  });

  it("of another epoch is stale, not wrong", () => {
    expect(decode(encodeSnapshot(2, 0), model(1), 0).kind).toBe("stale");
    expect(decode(encodeSnapshot(1, 0), null, 0).kind).toBe("stale");
  });

  it("of a wrong length or with other counts is refused", () => {
    const m = model();
    const whole = encodeSnapshot(1, 0, [CONTACT]);
    for (let length = 8; length < whole.byteLength; length += 3) {
      expect(() => decode(whole.slice(0, length), m, 0), `${length} bytes`).toThrow(ProtocolError);
    }
    const other = encodeSnapshot(1, 0);
    new DataView(other).setUint32(68, 6, true);
    expect(() => decode(other, m, 0)).toThrow(/other bodies/);
    const many = encodeSnapshot(1, 0);
    new DataView(many).setUint32(76, 0x7fffffff, true);
    expect(() => decode(many, m, 0)).toThrow(/contacts/);
  });

  it("of another protocol asks for a reload", () => {
    const bytes = encodeSnapshot(1, 0);
    new DataView(bytes).setUint8(1, 1);
    expect(() => decode(bytes, model(), 0)).toThrow("speaks protocol 1, this page 3. Reload");
  });
});

describe("a text message", () => {
  it("is read when known, skipped when not, refused when broken", () => {
    expect(decodeText('{"type":"pong","t":1,"server":2}')).toEqual({ type: "pong", t: 1, server: 2 });
    expect(decodeText('{"type":"news"}')).toBeNull();
    expect(() => decodeText('{"type":"pong"}')).toThrow(/lacks t/);
    expect(() => decodeText("{")).toThrow(ProtocolError);
    expect(() => decodeText('{"type":"constructor"}')).not.toThrow();
  });
});
