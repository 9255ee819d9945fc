// Draws the newest snapshot of a model, with the layers that are switched on.

import {
  Box3,
  Group,
  Matrix4,
  NeutralToneMapping,
  PCFShadowMap,
  PerspectiveCamera,
  Scene,
  Vector3,
  Vector4,
  WebGLRenderer,
} from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { SceneModel, Snapshot, Touch } from "../protocol/types";
import { CameraRig } from "./camera-rig";
import { DropMark } from "./drop-mark";
import { FrameClock } from "./frame-clock";
import { LAYERS_AT_FIRST, ON_SKIN, type LayerName, type ViewName } from "./layers";
import { Legend } from "./legend";
import { smoothShadows, type Shared } from "./materials";
import { Occluders } from "./occluders";
import { chooseQuality, PixelBudget, type Quality } from "./quality";
import { Surroundings } from "./surroundings";
import { FIRST_BONES } from "./weights";
import { WorldView } from "./world-view";

export interface StageStats {
  readonly frames: number;
  /** Frames drawn in the last second. */
  readonly fps: number;
  /** Processor time of one frame, median of 120, ms. */
  readonly frameCost: number;
  readonly triangles: number;
  /** Pixels drawn per pixel of the page. */
  readonly pixelRatio: number;
  readonly software: boolean;
}

/** Called before each frame with the time in ms, the frame's length in s and the XR frame, if any. */
export type FrameHook = (time: number, dt: number, frame: XRFrame | undefined) => void;

/** Without news, frames come this far apart, ms. */
const IDLE_FRAME = 250;
const IDLE_AFTER = 500;
/** At least half of the picture stays for what there is to see, whatever lies over it. */
const COVERED_MOST = 0.5;

export class Stage {
  readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(35, 1, 0.01, 12);
  /** Root of the simulated world: XR places and scales it. Its frame is the world frame of poses. */
  readonly world = new Group();
  readonly quality: Quality;
  readonly legend = new Legend();
  model: SceneModel | null = null;
  snapshot: Snapshot | null = null;

  private readonly rig: CameraRig;
  private readonly surroundings: Surroundings;
  private readonly shared: Shared;
  private readonly occluders = new Occluders();
  private readonly clock = new FrameClock();
  private readonly pixels: PixelBudget;
  private readonly hooks = new Set<FrameHook>();
  private readonly layers = new Set<LayerName>(LAYERS_AT_FIRST);
  private readonly clip = { value: new Vector4(0, 0, 0, 1) };
  private readonly drop = new DropMark();
  private below: Vector3 | null = null;
  private view: WorldView | null = null;
  private bones = FIRST_BONES;
  private devices: Touch["hands"] = [];
  private framed = false;
  private smooth = true;
  private covered = 0;
  private lastChange = 0;
  private lastDrawn = 0;
  private readonly focus = new Box3(new Vector3(-0.1, 0, -0.1), new Vector3(0.1, 0.1, 0.1));

  constructor(readonly canvas: HTMLCanvasElement) {
    this.quality = chooseQuality(new URLSearchParams(location.search).get("quality"));
    this.renderer = new WebGLRenderer({
      canvas,
      antialias: this.quality.antialias,
      stencil: true,
      powerPreference: "high-performance",
    });
    this.pixels = new PixelBudget(this.quality.software ? 0.6 : 0.5);
    smoothShadows(this.quality.shadowTaps);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.toneMappingExposure = 1.05;
    this.shared = {
      quality: this.quality,
      occluders: { value: this.occluders.spheres },
      sceneFromWorld: { value: new Matrix4() },
      pressureShown: { value: 0 },
      pressureMost: { value: 10e3 },
      weightsShown: { value: 0 },
    };
    this.surroundings = new Surroundings(this.shared, this.renderer, this.scene);
    this.world.add(this.surroundings.group, this.drop.group);
    this.scene.add(this.world);
    this.rig = new CameraRig(this.camera, canvas);
    this.rig.controls.addEventListener("change", () => this.invalidate());
    this.surroundings.surround(this.focus);
    this.surroundings.ground.visible = false;
    this.setView("scene");
    new ResizeObserver(() => {
      this.resize();
      // A new size empties the canvas: without this it would stay empty until the next frame.
      if (!this.renderer.xr.isPresenting) this.draw(performance.now());
    }).observe(canvas);
  }

  get controls(): OrbitControls {
    return this.rig.controls;
  }

  get stats(): StageStats {
    const { clock, renderer, quality } = this;
    return {
      frames: clock.frames,
      fps: clock.fps(performance.now()),
      frameCost: clock.cost,
      triangles: renderer.info.render.triangles,
      pixelRatio: renderer.getPixelRatio(),
      software: quality.software,
    };
  }

  /** Starts drawing; in XR the headset paces the frames. */
  start(): void {
    let before = performance.now();
    this.renderer.setAnimationLoop((time, frame) => {
      const dt = Math.max(0, (time - before) / 1000);
      before = time;
      for (const hook of this.hooks) hook(time, dt, frame);
      if (!this.renderer.xr.isPresenting) {
        this.rig.update();
        if (this.pixels.frame(dt)) this.resize();
      }
      this.render();
    });
  }

  onFrame(hook: FrameHook): () => void {
    this.hooks.add(hook);
    return () => this.hooks.delete(hook);
  }

  /** Something changed that the stage cannot know of: draw at full rate for a while. */
  invalidate(): void {
    this.lastChange = performance.now();
  }

  setModel(model: SceneModel): void {
    const sameScene = this.model?.scene === model.scene && this.model.hands.length === model.hands.length;
    if (this.view !== null) {
      this.world.remove(this.view.group);
      this.view.dispose();
    }
    this.model = model;
    this.snapshot = null;
    this.occluders.setModel(model);
    this.view = new WorldView(model, this.shared, this.clip, this.camera);
    this.view.interpolator.on = this.smooth;
    this.view.setWeightBones(this.bones);
    this.view.setTendons(this.devices);
    this.world.add(this.view.group);
    this.framed = false;
    if (!sameScene) this.setView("scene");
    this.applyLayers();
  }

  show(snapshot: Snapshot): void {
    if (this.view === null || snapshot.epoch !== this.model?.epoch) return;
    this.snapshot = snapshot;
    this.view.push(snapshot);
    this.invalidate();
  }

  setLayer(name: LayerName, on: boolean): void {
    if (on && ON_SKIN.includes(name)) for (const other of ON_SKIN) this.layers.delete(other);
    if (on) this.layers.add(name);
    else this.layers.delete(name);
    this.applyLayers();
  }

  layer(name: LayerName): boolean {
    return this.layers.has(name);
  }

  /** The bones whose skinning weights show, by name. */
  get weightBones(): readonly string[] {
    return this.bones;
  }

  setWeightBones(names: readonly string[]): void {
    this.bones = names;
    this.view?.setWeightBones(names);
    this.invalidate();
  }

  /** Forces of devices that hands wear; of those with tendons these are drawn. */
  setDevices(hands: Touch["hands"]): void {
    this.devices = hands;
    this.view?.setTendons(hands);
    if (hands.some((hand) => hand.renders === "tendons")) this.invalidate();
  }

  /** Shows motion between snapshots (the default) or only the snapshots themselves. */
  setInterpolation(on: boolean): void {
    this.smooth = on;
    if (this.view !== null) this.view.interpolator.on = on;
  }

  /** Cuts the flesh layer: leaves out cells beyond `part` (0 to 1) of the body along an axis of its
   * rest shape, or shows all with null. */
  setClip(axis: "x" | "y" | "z" | null, part = 0.5): void {
    this.clip.value.copy(this.view?.clipPlane(axis, part) ?? new Vector4(0, 0, 0, 1));
    this.invalidate();
  }

  /** Something lies over the lowest pixels of the canvas: what there is to see moves up beside it. */
  setCovered(pixels: number): void {
    if (pixels === this.covered) return;
    this.covered = pixels;
    this.resize();
  }

  /** Marks what is straight below a place, world frame, m; null: nothing. */
  markBelow(place: Vector3 | null): void {
    if (place === null && this.below === null) return;
    this.below = place;
    this.invalidate();
  }

  /** Height of what is marked, m; null: nothing is. */
  get markedHeight(): number | null {
    return this.drop.group.visible ? this.drop.group.position.y : null;
  }

  /** Shows what is behind everything; not where the visitor's own room is in view. */
  setBackdrop(on: boolean): void {
    this.surroundings.backdrop.visible = on;
  }

  setView(name: ViewName): void {
    this.rig.go(name, this.model?.camera ?? null, this.focus);
    this.invalidate();
  }

  /** Puts the camera somewhere, with another field of view if one is given, degrees. */
  placeCamera(position: readonly [number, number, number], target: readonly [number, number, number], fov: number | null): void {
    if (fov !== null) this.camera.fov = fov;
    this.rig.place(new Vector3(...position), new Vector3(...target));
    this.invalidate();
  }

  /** Where the moving content is, world frame. */
  bounds(): Box3 {
    return this.focus.clone();
  }

  private applyLayers(): void {
    this.invalidate();
    const on = (name: LayerName) => this.layers.has(name);
    this.surroundings.setShadows(on("shadows"));
    this.surroundings.ground.visible =
      on("ground") && (this.model?.rigids.some((rigid) => rigid.kind === "plane") ?? false);
    this.rig.keepAbove(this.surroundings.ground.visible ? 0 : null);
    this.shared.pressureShown.value = on("pressure") ? 1 : 0;
    this.shared.weightsShown.value = on("weights") ? 1 : 0;
    this.view?.setLayers(this.layers);
  }

  resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0 || this.renderer.xr.isPresenting) return;
    const ratio = Math.min(this.quality.pixelRatioMost, window.devicePixelRatio) * this.pixels.scale;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.rig.resize(clientWidth, clientHeight, Math.min(this.covered, COVERED_MOST * clientHeight));
    this.invalidate();
  }

  render(): void {
    const now = performance.now();
    const idle = now - this.lastChange > IDLE_AFTER && now - this.lastDrawn < IDLE_FRAME;
    if (idle && !this.renderer.xr.isPresenting) return;
    this.lastDrawn = now;
    this.draw(now);
    this.clock.add(now, performance.now() - now);
  }

  private draw(now: number): void {
    const { view } = this;
    if (view !== null && view.update(now)) {
      this.occluders.update(view.interpolator.rigids, view.interpolator.nodes);
      if (!this.framed) {
        this.framed = true;
        view.bounds(this.focus);
        if (this.model?.camera == null) this.rig.go("scene", null, view.scope());
        // A hand that was added to a scene stands where its camera does not look.
        else if (this.model.hands.length > 1) this.rig.include(view.handPlaces());
      }
      view.follow(this.focus);
      this.surroundings.surround(this.focus);
    }
    this.world.updateMatrixWorld();
    this.shared.sceneFromWorld.value.copy(this.world.matrixWorld).invert();
    this.drop.show(this.below, this.below === null ? null : (view?.surfaceBelow(this.below) ?? null));
    this.showLegend();
    this.renderer.render(this.scene, this.camera);
  }

  private showLegend(): void {
    const on = (name: LayerName) => this.layers.has(name);
    const pressure = on("pressure") ? (this.view?.pressureMost ?? null) : null;
    if (pressure !== null) this.shared.pressureMost.value = pressure;
    this.legend.show({
      pressure,
      force: on("forces") ? (this.view?.contacts.forceMost ?? null) : null,
      bones: on("weights") ? this.bones : null,
      joints: on("bones"),
      contacts: on("contacts"),
    });
  }

  /** A PNG of the present view, in its own size. */
  screenshot(width: number, height: number): Promise<Blob> {
    const { renderer, camera } = this;
    const aspect = camera.aspect;
    renderer.setPixelRatio(1);
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    // Also updates the projection.
    camera.clearViewOffset();
    this.draw(performance.now());
    const picture = new Promise<Blob>((resolve, reject) => {
      const done = (blob: Blob | null) =>
        blob === null ? reject(new Error("The browser made no picture.")) : resolve(blob);
      this.canvas.toBlob(done, "image/png");
    });
    camera.aspect = aspect;
    this.resize();
    this.draw(performance.now());
    return picture;
  }
}
