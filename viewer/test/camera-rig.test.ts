// The camera stays above a ground that is drawn, unless it was placed below it.

import { Box3, PerspectiveCamera, Vector3 } from "three";
import { expect, it } from "vitest";
import { CameraRig } from "../src/scene/camera-rig";

/** As much of a canvas as turns by mouse ask for. */
function canvas(): HTMLCanvasElement {
  const none = (): void => undefined;
  const root = { addEventListener: none, removeEventListener: none };
  return { style: {}, ...root, getRootNode: () => root, ownerDocument: root } as unknown as HTMLCanvasElement;
}

function rig(): CameraRig {
  return new CameraRig(new PerspectiveCamera(35, 1.5, 0.01, 12), canvas());
}

const TABLE = new Box3(new Vector3(-0.1, 0, -0.1), new Vector3(0.1, 0.1, 0.1));
const OWN = { position: [-0.36, 0.21, 0.33], target: [0, 0.05, 0], up: [0, 1, 0], fov_deg: 32 } as const;

it("comes up again when a drag, a shift or the wheel would take it below the ground", () => {
  const eye = rig();
  eye.go("scene", OWN, TABLE);
  eye.keepAbove(0);
  eye.update();
  expect(eye.camera.position.toArray()).toEqual(OWN.position.map((x) => expect.closeTo(x, 9)));
  const distance = eye.controls.getDistance();
  // A drag: as far from the target, seen from below.
  eye.camera.position.copy(eye.controls.target).add(new Vector3(0, -0.3, 0.3).setLength(distance));
  eye.update();
  expect(eye.camera.position.y).toBeCloseTo(0.02, 6);
  expect(eye.controls.getDistance()).toBeCloseTo(distance, 6);
  // A shift, of the target too, from a low place.
  for (const place of [eye.camera.position, eye.controls.target]) place.y -= 0.3;
  eye.update();
  expect(eye.controls.target.y).toBe(0);
  expect(eye.camera.position.y).toBeGreaterThan(0.019);
});

it("goes anywhere where there is no ground", () => {
  const eye = rig();
  eye.go("scene", OWN, TABLE);
  eye.camera.position.y = -0.4;
  eye.update();
  expect(eye.camera.position.y).toBeCloseTo(-0.4, 9);
});

it("stays below the ground where it was placed there, until it comes up", () => {
  const eye = rig();
  eye.keepAbove(0);
  eye.go("below", OWN, TABLE);
  const { y } = eye.camera.position;
  expect(y).toBeLessThan(-0.1);
  eye.update();
  expect(eye.camera.position.y).toBeCloseTo(y, 9);
  eye.camera.position.y = 0.2;
  eye.update();
  eye.camera.position.y = -0.2;
  eye.update();
  expect(eye.camera.position.y).toBeGreaterThan(0.019);
});

it("sees its target in the middle of the part of the canvas that nothing covers, as large as that part allows", () => {
  const eye = rig();
  eye.resize(600, 300);
  eye.go("scene", OWN, TABLE);
  /** Pixels below the canvas's upper edge. */
  const down = (y: number, height: number): number => {
    eye.camera.updateMatrixWorld();
    return (height * (1 - new Vector3(OWN.target[0], y, OWN.target[2]).project(eye.camera).y)) / 2;
  };
  expect(down(OWN.target[1], 300)).toBeCloseTo(150, 6);
  const size = down(0, 300) - down(0.1, 300);
  eye.resize(600, 300, 100);
  expect(down(OWN.target[1], 300)).toBeCloseTo(100, 6);
  expect(down(0, 300) - down(0.1, 300)).toBeCloseTo((size * 2) / 3, 6);
  eye.resize(600, 300);
  expect(down(OWN.target[1], 300)).toBeCloseTo(150, 6);
});
