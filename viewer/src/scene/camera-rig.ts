// Where the eye goes: orbiting by mouse and touch, and a few places to jump to.

import { Box3, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { SceneCamera } from "../protocol/types";
import type { ViewName } from "./layers";

/** Scenes are framed for a window this much wider than high; narrower ones step back. */
const FRAMED_FOR = 1.5;

const DIRECTIONS: Readonly<Record<Exclude<ViewName, "scene">, readonly [number, number, number]>> = {
  front: [0, 0.22, 1],
  side: [-1, 0.22, 0],
  top: [0, 1, 0.001],
  below: [0.25, -1, 0.45],
  close: [-0.7, 0.42, 0.75],
};

/** A camera is kept so far above the ground, m. */
const CLEARANCE = 0.02;

/** In view: within this share of the picture, from its middle. */
const EDGE = 0.85;

export class CameraRig {
  readonly controls: OrbitControls;
  private view: ViewName = "scene";
  private ground: number | null = null;
  /** The camera may be below the ground: it was placed there. */
  private free = true;

  constructor(
    readonly camera: PerspectiveCamera,
    canvas: HTMLCanvasElement,
  ) {
    this.controls = new OrbitControls(camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.minDistance = 0.03;
    this.controls.maxDistance = 6;
    this.controls.zoomSpeed = 0.8;
  }

  get current(): ViewName {
    return this.view;
  }

  /** Goes to a preset; `content` is what should be seen. */
  go(view: ViewName, own: SceneCamera | null, content: Box3): void {
    this.view = view;
    const { camera, controls } = this;
    const away = new Vector3();
    if (view === "scene" && own !== null) {
      controls.target.fromArray(own.target);
      away.fromArray(own.position).sub(controls.target);
      camera.fov = own.fov_deg;
    } else {
      content.getCenter(controls.target);
      camera.fov = 32;
      const size = Math.max(0.05, content.getSize(new Vector3()).length());
      // What has no camera of its own moves, nobody knows where to: room around it.
      const part = view === "close" ? 0.26 : view === "scene" ? 0.8 : 0.5;
      away.fromArray(DIRECTIONS[view === "scene" ? "close" : view]).normalize();
      away.multiplyScalar((part * size) / Math.tan((camera.fov * Math.PI) / 360));
    }
    away.multiplyScalar(Math.max(1, Math.min(2.4, FRAMED_FOR / Math.max(0.2, camera.aspect))));
    this.place(away.add(controls.target), controls.target);
  }

  /** Puts the camera somewhere, below the ground too: turns and shifts keep it above only from above. */
  place(position: Vector3, target: Vector3): void {
    const { camera, controls } = this;
    camera.position.copy(position);
    controls.target.copy(target);
    camera.updateProjectionMatrix();
    this.settle();
    controls.update();
  }

  /** Turns and shifts end above a ground of this height, m; with null they go anywhere. */
  keepAbove(ground: number | null): void {
    if (ground === this.ground) return;
    this.ground = ground;
    this.settle();
  }

  /** To be called before each frame. */
  update(): void {
    const { camera, controls } = this;
    controls.update();
    const least = this.lowest();
    if (least === null) return;
    if (camera.position.y >= least) this.free = false;
    if (this.free) return;
    const sunk = (this.ground ?? least) - controls.target.y;
    if (sunk > 0) {
      controls.target.y += sunk;
      camera.position.y += sunk;
    }
    // At its widest the angle from the vertical leaves the camera just above the ground.
    const cosine = (least - controls.target.y) / Math.max(controls.getDistance(), 1e-9);
    controls.maxPolarAngle = Math.acos(Math.min(1, Math.max(-1, cosine)));
    if (camera.position.y < least) controls.update();
  }

  /** The lowest height of the camera, if there is one. */
  private lowest(): number | null {
    return this.ground === null ? null : this.ground + CLEARANCE;
  }

  /** Takes the camera's place as meant. */
  private settle(): void {
    const least = this.lowest();
    this.free = least === null || this.camera.position.y < least;
    this.controls.maxPolarAngle = Math.PI;
  }

  /** Steps back until the places are in view, or twice as far. */
  include(places: readonly Vector3[]): void {
    const { camera, controls } = this;
    const seen = (place: Vector3) => {
      const { x, y } = place.clone().project(camera);
      return Math.abs(x) < EDGE && Math.abs(y) < EDGE;
    };
    for (let step = 0; step < 8; step++) {
      camera.lookAt(controls.target);
      camera.updateMatrixWorld();
      if (places.every(seen)) break;
      camera.position.sub(controls.target).multiplyScalar(1.09).add(controls.target);
    }
    controls.update();
  }

  /** Takes a canvas of this size, px, whose lowest `covered` are behind something: the view is that of the part above,
   * and goes on below it. */
  resize(width: number, height: number, covered = 0): void {
    const aspect = width / (height - covered);
    // A turned phone keeps what it saw.
    const factor = (a: number) => Math.max(1, Math.min(2.4, FRAMED_FOR / Math.max(0.2, a)));
    const scale = factor(aspect) / factor(this.camera.aspect);
    this.camera.position.sub(this.controls.target).multiplyScalar(scale).add(this.controls.target);
    this.camera.aspect = aspect;
    if (covered > 0) this.camera.setViewOffset(width, height - covered, 0, 0, width, height);
    else this.camera.clearViewOffset();
  }
}
