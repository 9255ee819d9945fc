// A dragged hand goes where the pointer goes, in an upright or a level plane.

import { PerspectiveCamera, Ray, Raycaster, Vector2, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { dragNormal, dragStep } from "../../src/input/drag-plane";

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
