// Normals and skinning against what theory says for simple motions.

import { describe, expect, it } from "vitest";
import { Deformation } from "../src/scene/deformation";
import { Interpolator } from "../src/scene/interpolate";
import { PressureMap } from "../src/scene/pressure";
import { restPoses, skinNodes } from "../src/scene/skinning";
import { restPositions, vertexAreas, vertexNormals } from "../src/scene/surface";
import { decode } from "../src/protocol/decode";
import type { SceneModel, Snapshot } from "../src/protocol/types";
import { encodeSnapshot, encodeWorld, NODES, TETS, type TestContact } from "./encode-world";

const rest = Float32Array.from(NODES);
const tets = Uint32Array.from(TETS);

function world(): SceneModel {
  const message = decode(encodeWorld(), null, 0);
  if (message.kind !== "model") throw new Error(message.kind);
  return message.model;
}

function snapshot(model: SceneModel, rise: number, at: number): Snapshot {
  const message = decode(encodeSnapshot(1, rise), model, at);
  if (message.kind !== "snapshot") throw new Error(message.kind);
  return message.snapshot;
}

/** The cofactor at a node, as three columns. */
function cofactor(deformation: Deformation, node: number): number[][] {
  return [4, 8, 12].map((k) => Array.from(deformation.data.slice(16 * node + k, 16 * node + k + 3)));
}

describe("a deformation", () => {
  it("that is linear gives its cofactor at every node", () => {
    // x' = F x + t, with F sheared and stretched; cof F = det F · F⁻ᵀ, worked out by hand.
    const F = [
      [2, 1, 0],
      [0, 3, 0],
      [0, 0, 0.5],
    ];
    const cof = [
      [1.5, 0, 0],
      [-0.5, 1, 0],
      [0, 0, 6],
    ];
    const moved = new Float32Array(3 * 7);
    for (let n = 0; n < 5; n++) {
      for (let i = 0; i < 3; i++) {
        moved[6 + 3 * n + i] =
          0.3 + F[i][0] * rest[3 * n] + F[i][1] * rest[3 * n + 1] + F[i][2] * rest[3 * n + 2];
      }
    }
    const deformation = new Deformation(rest, tets);
    deformation.update(moved, 2);
    for (let n = 0; n < 5; n++) {
      cofactor(deformation, n).forEach((column, j) =>
        column.forEach((value, i) => expect(value).toBeCloseTo(cof[i][j], 4)),
      );
      expect(deformation.data[16 * n]).toBe(moved[6 + 3 * n]);
    }
  });

  it("works on nodes beyond the first row of the texture", () => {
    const many = new Float32Array(3 * 4 * 300);
    const all = new Uint32Array(4 * 300);
    for (let t = 0; t < 300; t++) {
      many.set(rest.slice(0, 12), 12 * t);
      all.set(
        [0, 1, 2, 3].map((k) => 4 * t + k),
        4 * t,
      );
    }
    const deformation = new Deformation(many, all);
    expect(deformation.texture.image.height).toBe(5);
    expect(cofactor(deformation, 1199)[2][2]).toBeCloseTo(1, 5);
  });
});

describe("skinning", () => {
  it("follows a turn and a shift that all bones share", () => {
    const model = world();
    const skin = model.softs[0].skin;
    if (skin === null) throw new Error("no skin");
    // A quarter turn about z, then up by one: (x, y, z) to (-y, x + 1, z).
    const half = Math.SQRT1_2;
    const pose = [0, 1, 0, 0, 0, half, half];
    const out = new Float32Array(15);
    expect(skinNodes(skin, Float32Array.from([...pose, ...pose]), 1, out)).toBe(true);
    for (let n = 0; n < 5; n++) {
      expect(out[3 * n]).toBeCloseTo(-rest[3 * n + 1], 6);
      expect(out[3 * n + 1]).toBeCloseTo(rest[3 * n] + 1, 6);
      expect(out[3 * n + 2]).toBeCloseTo(rest[3 * n + 2], 6);
    }
  });

  it("says when poses are not known", () => {
    const model = world();
    const skin = model.softs[0].skin;
    if (skin === null) throw new Error("no skin");
    expect(skinNodes(skin, new Float32Array(14).fill(NaN), 1, new Float32Array(15))).toBe(false);
  });

  it("knows where bones were in the rest shape", () => {
    // Offsets in the test world are the nodes themselves: bones rest at the origin, unturned.
    const model = world();
    const [soft, hand] = [model.softs[0], model.hands[0]];
    if (soft.skin === null) throw new Error("no skin");
    const poses = restPoses(soft, soft.skin, hand);
    [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0].forEach((value, i) => expect(poses[i]).toBeCloseTo(value, 4));
  });
});

describe("pressure", () => {
  const FLESH = 32768;
  const UP: [number, number] = [0, 0];
  const contact = (force: number, area: number, place: number[], vertices: [number, number]) => ({
    bodies: [FLESH, 3] as const,
    vertices,
    numbers: [...place, 0, 0, force, 0, area, 0, 0],
    normal: UP,
  });
  const pressed = (contacts: readonly TestContact[]) => {
    const model = world();
    const message = decode(encodeSnapshot(1, 0, contacts), model, 0);
    if (message.kind !== "snapshot") throw new Error(message.kind);
    const out = new Float32Array(4);
    const peak = new PressureMap(model.softs[0]).update(message.snapshot, 0, out);
    const positions = Float32Array.from([0, 1, 2, 4].flatMap((n) => NODES.slice(3 * n, 3 * n + 3)));
    const areas = vertexAreas(positions, model.softs[0].render.triangles);
    return { out, peak, areas, force: out.reduce((sum, p, v) => sum + p * areas[v], 0) };
  };

  it("times area is the normal force, whatever the area", () => {
    for (const area of [0, 1e-6, 1e-4, 1e-2]) {
      const { force } = pressed([
        contact(3, area, [0.01, 0, 0], [1, 65535]),
        contact(0.5, area, [0.01, 0.01, 0.01], [3, 65535]),
        contact(-1, area, [0, 0, 0], [0, 65535]),
      ]);
      expect(force, `${area} m²`).toBeCloseTo(3.5, 4);
    }
    // Friction along the skin is no pressure.
    const shear = { ...contact(0, 1e-4, [0, 0, 0], [0, 65535]), normal: [32767, 0] as [number, number] };
    expect(pressed([shear]).force).toBe(0);
  });

  it("is force over area where one contact covers a vertex alone", () => {
    const { areas } = pressed([]);
    // Its area is the vertex's own, so the bell sinks to exp(-π r²/A) at the next, 14 mm away.
    const { out, peak } = pressed([contact(2, areas[0], [0, 0, 0], [0, 65535])]);
    expect(peak).toBe(out[0]);
    const others = Math.exp((-Math.PI * 1e-4) / areas[0]);
    expect(out[0] / (2 / areas[0])).toBeGreaterThan(1 - 8 * others);
    expect(out[0] / (2 / areas[0])).toBeLessThanOrEqual(1 + 1e-6);
  });

  it("is drawn no finer than collision vertices are apart", () => {
    const { collision, nodes, tets } = world().softs[0];
    const [share] = vertexAreas(restPositions(collision, nodes, tets), collision.triangles);
    const at = (area: number) => pressed([contact(2, area, [0, 0, 0], [0, 65535])]);
    expect(at(0).out).toEqual(at(0.99 * share).out);
    expect(at(4 * share).peak).toBeLessThan(at(0).peak);
  });

  it("goes by the contact's place, not by its vertex", () => {
    const { out } = pressed([contact(1, 1e-5, [0, 0.0099, 0], [1, 65535])]);
    expect(Math.max(...out)).toBe(out[2]);
  });

  it("of a body on itself presses on both sides", () => {
    const self = { ...contact(1, 1e-6, [0, 0, 0], [0, 3]), bodies: [FLESH, FLESH] as const };
    expect(pressed([self]).force).toBeCloseTo(2, 4);
  });
});

describe("normals", () => {
  it("of a cube's corners, each triangle corner weighted by its angle, point along the diagonals", () => {
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => [i & 1, (i >> 1) & 1, i >> 2]);
    const quads = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
    const triangles: number[] = [];
    for (let q = 0; q < 24; q += 4)
      triangles.push(quads[q], quads[q + 1], quads[q + 2], quads[q], quads[q + 2], quads[q + 3]);
    const normals = vertexNormals(Float32Array.from(corners), Uint32Array.from(triangles));
    corners.forEach((c, i) => expect(normals[i]).toBeCloseTo((c === 1 ? 1 : -1) / Math.sqrt(3), 5));
  });
});

describe("between two snapshots", () => {
  it("shows the way from the last but one to the last, one interval late at most", () => {
    const model = world();
    const between = new Interpolator(model);
    between.push(snapshot(model, 0, 100));
    expect(between.update(100)).toBe(true);
    between.push(snapshot(model, 1, 116));
    between.update(116);
    expect(between.nodes[1]).toBeCloseTo(0, 6);
    between.update(124);
    expect(between.nodes[1]).toBeCloseTo(0.5, 5);
    between.update(132);
    expect(between.nodes[1]).toBe(1);
    expect(between.update(140)).toBe(false);
    expect(between.rigids[1]).toBe(1);
  });

  it("shows the newest at once when switched off, and after a long pause", () => {
    const model = world();
    const between = new Interpolator(model);
    between.push(snapshot(model, 0, 100));
    between.push(snapshot(model, 1, 900));
    between.update(900);
    expect(between.nodes[1]).toBe(1);
    between.on = false;
    between.push(snapshot(model, 2, 916));
    between.update(916);
    expect(between.nodes[1]).toBe(2);
  });
});
