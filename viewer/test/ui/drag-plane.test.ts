// A dragged hand goes where the pointer goes, in an upright or a level plane.

import { PerspectiveCamera, Ray, Raycaster, Vector2, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { dragNormal, dragStep, leanTowards } from "../../src/input/drag-plane";

const HAND = new Vector3(0.02, 0.1, 0.03);

/** A camera that looks at the middle from `position`, and what its pointer does. */
function seenFrom(...position: [number, number, number]) {
  const camera = new PerspectiveCamera(35, 1.5, 0.01, 12);
  camera.position.set(...position);
  camera.lookAt(0, 0, 0);
  camera.updateMatrixWorld();
  const caster = new Raycaster();
  const ray = (at: Vector2): Ray => {
    caster.setFromCamera(at, camera);
    return caster.ray.clone();
  };
  const place = (point: Vector3): Vector2 => {
    const { x, y } = point.clone().project(camera);
    return new Vector2(x, y);
  };
  const view = HAND.clone().sub(camera.position).normalize();
  return { ray, place, view };
}

/** One step of the hand when the pointer goes from it by `by` of half the picture. */
function step(camera: ReturnType<typeof seenFrom>, kind: "upright" | "level", by: Vector2): Vector3 {
  const from = camera.place(HAND);
  const moved = dragStep(camera.ray(from), camera.ray(from.clone().add(by)), HAND, dragNormal(kind, camera.view));
  if (moved === null) throw new Error("the pointer misses the plane");
  return moved;
}

describe("an upright drag", () => {
  it("keeps the distance on the table: down is down, no nearer", () => {
    const camera = seenFrom(0.3, 0.35, 0.6);
    const moved = step(camera, "upright", new Vector2(0, -0.1));
    const away = camera.view.clone().setY(0).normalize();
    expect(moved.dot(away)).toBeCloseTo(0, 12);
    expect(moved.y).toBeLessThan(-0.01);
  });

  it("leaves the grabbed point under the pointer", () => {
    const camera = seenFrom(-0.4, 0.25, 0.5);
    const by = new Vector2(0.15, -0.12);
    const at = camera.place(HAND.clone().add(step(camera, "upright", by)));
    const wanted = camera.place(HAND).add(by);
    expect(at.x).toBeCloseTo(wanted.x, 9);
    expect(at.y).toBeCloseTo(wanted.y, 9);
  });

  it("is in the plane of the picture where the camera looks straight down", () => {
    const view = new Vector3(0, -1, 0);
    expect(dragNormal("upright", view)).toEqual(view);
  });
});

describe("a thing under the hand", () => {
  const camera = seenFrom(0.3, 0.35, 0.6);
  const away = camera.view.clone().setY(0).normalize();
  const aside = new Vector3(-away.z, 0, away.x);
  /** `down` below the hand, `far` behind it, `right` of it, m. */
  const at = (down: number, far: number, right = 0): Vector3 =>
    HAND.clone().addScaledVector(away, far).addScaledVector(aside, right).setY(HAND.y - down);
  const lean = (...things: Vector3[]): number => leanTowards(HAND, things, camera.view);

  it("draws the way down to it, but for a finger's breadth", () => {
    const tilt = lean(at(0.1, 0.06));
    let hand = HAND.clone();
    // Down until the hand has the thing's height.
    while (hand.y > HAND.y - 0.1) {
      const from = camera.place(hand);
      const normal = dragNormal("upright", camera.view, tilt);
      hand = hand.add(dragStep(camera.ray(from), camera.ray(from.clone().add(new Vector2(0, -0.002))), hand, normal)!);
    }
    expect(hand.clone().sub(HAND).dot(away)).toBeCloseTo(0.04, 2);
    expect(hand.clone().sub(HAND).dot(aside)).toBeCloseTo(0, 2);
  });

  it("leaves the grabbed point under the pointer, and the way back is the way", () => {
    const normal = dragNormal("upright", camera.view, lean(at(0.1, 0.06)));
    const [from, to] = [camera.place(HAND), camera.place(HAND).add(new Vector2(0.1, -0.15))];
    const there = dragStep(camera.ray(from), camera.ray(to), HAND, normal)!;
    expect(camera.place(HAND.clone().add(there)).distanceTo(to)).toBeLessThan(1e-9);
    const back = dragStep(camera.ray(to), camera.ray(from), HAND.clone().add(there), normal)!;
    expect(back.add(there).length()).toBeLessThan(1e-12);
  });

  it("is no help where the hand is right above it, beside it, or at it", () => {
    expect(lean(at(0.1, 0.015))).toBe(0);
    expect(lean(at(0.1, 0.08, 0.08))).toBe(0);
    expect(lean(at(0.01, 0.009))).toBe(0);
    expect(lean(at(-0.1, 0.05))).toBe(0);
    expect(lean()).toBe(0);
  });

  it("leans 30 degrees at most, both ways, and towards the nearest", () => {
    expect(lean(at(0.1, 0.095))).toBeCloseTo(Math.tan(Math.PI / 6), 12);
    expect(lean(at(0.1, -0.095))).toBeCloseTo(-Math.tan(Math.PI / 6), 12);
    expect(lean(at(0.2, 0.1), at(0.1, -0.05))).toBeCloseTo(-0.3, 12);
  });

  it("never lays the plane along the view: then it stands upright", () => {
    const steep = new Vector3(0, -Math.sin(1), -Math.cos(1));
    expect(dragNormal("upright", steep, Math.tan(Math.PI / 6))).toEqual(new Vector3(0, 0, -1));
  });
});

describe("a level drag", () => {
  it("keeps the height, and the point under the pointer", () => {
    const camera = seenFrom(0.3, 0.35, 0.6);
    const by = new Vector2(0.05, 0.1);
    const moved = step(camera, "level", by);
    expect(moved.y).toBeCloseTo(0, 12);
    const at = camera.place(HAND.clone().add(moved));
    expect(at.distanceTo(camera.place(HAND).add(by))).toBeLessThan(1e-9);
  });

  it("falls back to the plane of the picture where the camera looks along the table", () => {
    const view = new Vector3(0, -Math.sin(0.1), -Math.cos(0.1));
    expect(dragNormal("level", view)).toEqual(view);
  });
});

it("a pointer above the horizon moves nothing", () => {
  const origin = new Vector3(0, 0.2, 1);
  const down = new Ray(origin, new Vector3(0, -0.2, -1).normalize());
  const up = new Ray(origin, new Vector3(0, 0.2, -1).normalize());
  expect(dragStep(down, up, new Vector3(), new Vector3(0, 1, 0))).toBeNull();
});
