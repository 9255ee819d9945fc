// Draws the newest snapshot of a model.

import {
  AmbientLight,
  Box3,
  BoxGeometry,
  CapsuleGeometry,
  Color,
  DirectionalLight,
  Group,
  Mesh,
  MeshStandardMaterial,
  PerspectiveCamera,
  Points,
  PointsMaterial,
  BufferGeometry,
  BufferAttribute,
  Scene,
  SphereGeometry,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { RigidModel, SceneModel, Snapshot } from "../protocol/types";
import { LAYERS_AT_FIRST, type LayerName, type ViewName } from "./layers";

export interface StageStats {
  frames: number;
  /** Frames drawn in the last second. */
  fps: number;
  /** CPU cost of one frame, median of 120, ms. */
  frameCost: number;
  triangles: number;
}

/** Called before each frame with the time in ms, the frame's length in s and the XR frame, if any. */
export type FrameHook = (time: number, dt: number, frame: XRFrame | undefined) => void;

export class Stage {
  readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(35, 1, 0.005, 20);
  readonly controls: OrbitControls;
  /** Root of the simulated world: XR places and scales it. Its frame is the world frame of poses. */
  readonly world = new Group();
  readonly stats: StageStats = { frames: 0, fps: 0, frameCost: 0, triangles: 0 };
  model: SceneModel | null = null;
  snapshot: Snapshot | null = null;

  private readonly hooks = new Set<FrameHook>();
  private readonly layers = new Set<LayerName>(LAYERS_AT_FIRST);
  private rigids: (Mesh | null)[] = [];
  private points: Points | null = null;

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.scene.background = new Color(0x15181c);
    const key = new DirectionalLight(0xffffff, 2);
    key.position.set(0.3, 1, 0.5);
    this.scene.add(new AmbientLight(0xffffff, 0.6), key, this.world);
    this.controls = new OrbitControls(this.camera, canvas);
    this.setView("scene");
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** Starts drawing; in XR the headset paces the frames. */
  start(): void {
    let before = performance.now();
    this.renderer.setAnimationLoop((time, frame) => {
      const dt = Math.min(0.1, (time - before) / 1000);
      before = time;
      for (const hook of this.hooks) hook(time, dt, frame);
      this.render();
    });
  }

  onFrame(hook: FrameHook): () => void {
    this.hooks.add(hook);
    return () => this.hooks.delete(hook);
  }

  setModel(model: SceneModel): void {
    this.model = model;
    this.snapshot = null;
    this.world.clear();
    this.rigids = model.rigids.map((rigid) => {
      const mesh = shape(rigid);
      if (mesh !== null) this.world.add(mesh);
      return mesh;
    });
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * model.node_count), 3));
    this.points = new Points(geometry, new PointsMaterial({ size: 0.002, color: 0xe0a98f }));
    this.points.frustumCulled = false;
    this.world.add(this.points);
    this.setView("scene");
  }

  show(snapshot: Snapshot): void {
    this.snapshot = snapshot;
    this.rigids.forEach((mesh, i) => {
      const at = 7 * i;
      mesh?.position.fromArray(snapshot.rigids, at);
      mesh?.quaternion.fromArray(snapshot.rigids, at + 3);
    });
    const position = this.points?.geometry.getAttribute("position");
    if (position instanceof BufferAttribute) {
      (position.array as Float32Array).set(snapshot.nodes);
      position.needsUpdate = true;
    }
  }

  setLayer(name: LayerName, on: boolean): void {
    if (on) this.layers.add(name);
    else this.layers.delete(name);
  }

  layer(name: LayerName): boolean {
    return this.layers.has(name);
  }

  setView(_name: ViewName): void {
    const camera = this.model?.camera;
    this.camera.position.copy(new Vector3(...(camera?.position ?? [0.3, 0.25, 0.4])));
    this.controls.target.copy(new Vector3(...(camera?.target ?? [0, 0.05, 0])));
    this.controls.update();
  }

  /** Where the content is, world frame. */
  bounds(): Box3 {
    return new Box3().setFromObject(this.world);
  }

  resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
  }

  render(): void {
    this.renderer.render(this.scene, this.camera);
    this.stats.frames += 1;
  }

  /** A PNG of the present view. */
  screenshot(_width: number, _height: number): Promise<Blob> {
    this.render();
    return new Promise((resolve, reject) =>
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("No picture."))), "image/png"),
    );
  }
}

function shape(rigid: RigidModel): Mesh | null {
  const material = new MeshStandardMaterial({ color: 0xb08a5a, roughness: 0.7 });
  switch (rigid.kind) {
    case "box": {
      const [x, y, z] = rigid.half ?? [0.01, 0.01, 0.01];
      return new Mesh(new BoxGeometry(2 * x, 2 * y, 2 * z), material);
    }
    case "sphere":
      return new Mesh(new SphereGeometry(rigid.radius ?? 0.01, 32, 16), material);
    case "capsule":
      return new Mesh(new CapsuleGeometry(rigid.radius ?? 0.01, 2 * (rigid.half_length ?? 0.01)), material);
    default:
      return null;
  }
}
