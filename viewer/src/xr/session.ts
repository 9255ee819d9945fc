// One XR session: the world stands before the visitor, the visitor's hands or controllers move those of the scene, forces
// come back as colour, numbers and vibration. Made when a session begins, ended with it.

import { Vector3, type PerspectiveCamera } from "three";
import type { App } from "../app";
import type { Side } from "../protocol/types";
import type { LayerName } from "../scene/layers";
import { wristNumbers } from "../input/hand-pose";
import { HandsRequest, PoseOutlet, SIDES } from "../tracking/outlet";
import { identity, inverse, type Rigid } from "../tracking/rigid";
import { placeWorld } from "./anchor";
import { XrControllers } from "./controllers";
import { digitForces, totalForce } from "./forces";
import { Haptics } from "./haptics";
import { XrHands } from "./hands";
import { XrPanel } from "./panel";
import { RecentreGesture } from "./recentre";
import { Sizing } from "./sizing";
import { TrackedView } from "./tracked-view";

/** Layers set while in XR, whatever they are on the desk: arrows tell of touch. */
const LAYERS_IN_XR: readonly (readonly [LayerName, boolean])[] = [["forces", true]];
/** With the room in view its own floor and table are enough. */
const LAYERS_IN_ROOM: readonly (readonly [LayerName, boolean])[] = [...LAYERS_IN_XR, ["ground", false]];

interface Desk {
  readonly position: Vector3;
  readonly camera: PerspectiveCamera;
  readonly layers: readonly (readonly [LayerName, boolean])[];
}

export class XrLive {
  readonly hands = new XrHands();
  readonly controllers = new XrControllers();
  readonly sizing = new Sizing();
  frames = 0;
  /** Of the newest frame, s. */
  time = 0;
  private readonly panel = new XrPanel();
  private readonly view = new TrackedView();
  private readonly haptics = new Haptics();
  private readonly recentreGesture = new RecentreGesture();
  private readonly outlet: PoseOutlet;
  private readonly request: HandsRequest;
  private readonly desk: Desk;
  private readonly undo: (() => void)[] = [];
  /** Takes the reference space to the simulated world; null until the head is seen. */
  private toWorld: Rigid | null = null;

  constructor(
    private readonly app: App,
    readonly session: XRSession,
    readonly floorKnown: boolean,
    transparent: boolean,
  ) {
    const { stage, connection } = app;
    this.outlet = new PoseOutlet(connection);
    this.request = new HandsRequest(connection);
    const layers = transparent ? LAYERS_IN_ROOM : LAYERS_IN_XR;
    this.desk = {
      position: stage.world.position.clone(),
      camera: stage.camera.clone(),
      layers: layers.map(([name]) => [name, stage.layer(name)] as const),
    };
    stage.setBackdrop(!transparent);
    for (const [name, on] of layers) stage.setLayer(name, on);
    stage.controls.enabled = false;
    this.undo.push(
      stage.onFrame((time, _dt, frame) => this.frame(time / 1000, frame)),
      connection.on("open", () => this.request.forget()),
    );
    session.addEventListener("visibilitychange", this.visibility);
  }

  /** Sides of the hands that move. */
  led(): readonly Side[] {
    return this.outlet.led();
  }

  /** Sides of the hands or controllers that are seen. */
  seen(): readonly Side[] {
    const { hands, controllers, time } = this;
    return SIDES.filter((side) => !hands.lost(side, time) || !controllers.lost(side, time));
  }

  /** The scene comes before the visitor again at the next frame. */
  recentre(): void {
    this.toWorld = null;
  }

  /** Lets everything go and puts the desk back. */
  dispose(): void {
    const { stage } = this.app;
    this.session.removeEventListener("visibilitychange", this.visibility);
    for (const undo of this.undo) undo();
    this.outlet.lostAll();
    this.request.restore();
    this.panel.dispose();
    this.view.dispose();
    stage.world.position.copy(this.desk.position);
    stage.world.quaternion.identity();
    stage.setBackdrop(true);
    for (const [name, on] of this.desk.layers) stage.setLayer(name, on);
    stage.controls.enabled = true;
  }

  /** Once the session has ended: three moves the page's camera with the head until then. */
  restoreCamera(): void {
    const { stage } = this.app;
    stage.camera.copy(this.desk.camera, false);
    stage.resize();
    stage.controls.update();
  }

  private readonly visibility = (): void => {
    // No frames come while hidden, so nothing else would say so.
    if (this.session.visibilityState !== "visible") this.outlet.lostAll();
  };

  private get centre(): Vector3 {
    const target = this.app.connection.model?.camera?.target;
    return target === undefined ? new Vector3() : new Vector3(target[0], 0, target[2]);
  }

  private frame(time: number, frame: XRFrame | undefined): void {
    const space = this.app.stage.renderer.xr.getReferenceSpace();
    if (frame === undefined || space === null || frame.session !== this.session) return;
    this.frames += 1;
    this.time = time;
    if (this.toWorld === null && !this.placeWorld(frame, space)) return;
    const toWorld = this.toWorld ?? identity();
    this.hands.read(frame, space, toWorld, time);
    this.controllers.read(frame, space, toWorld, time);
    this.send(time);
    this.feedBack(time);
  }

  private placeWorld(frame: XRFrame, space: XRReferenceSpace): boolean {
    const viewer = frame.getViewerPose(space)?.transform;
    if (viewer === undefined) return false;
    const head = identity();
    head.position.set(viewer.position.x, viewer.position.y, viewer.position.z);
    const { x, y, z, w } = viewer.orientation;
    head.rotation.set(x, y, z, w);
    const world = placeWorld(head, this.centre, this.floorKnown);
    this.app.stage.world.position.copy(world.position);
    this.app.stage.world.quaternion.copy(world.rotation);
    this.toWorld = inverse(world);
    return true;
  }

  private send(time: number): void {
    for (const side of SIDES) {
      const joints = this.hands.fresh(side);
      if (joints !== null) {
        this.sizing.add(side, joints, time);
        this.outlet.joints(side, joints);
      } else if (this.controllers.fresh(side)) {
        this.sizing.hold(side, time);
        this.sendHeld(side, time);
      } else if (this.hands.lost(side, time) && this.controllers.lost(side, time)) {
        this.outlet.lost(side);
      }
    }
    const wanted = this.sizing.wanted(time);
    if (wanted !== null) this.request.ask(wanted);
  }

  private sendHeld(side: Side, time: number): void {
    const hand = this.app.connection.model?.hands.find((candidate) => candidate.side === side);
    if (hand === undefined) return;
    const pose = this.controllers.pose(side, hand, time);
    this.outlet.angles(side, wristNumbers(pose), pose.angles);
  }

  private feedBack(time: number): void {
    const { stage } = this.app;
    // The stage clears its world with every new model.
    if (this.panel.mesh.parent === null) {
      this.panel.place(this.centre);
      stage.world.add(this.panel.mesh);
    }
    if (this.view.mesh.parent === null) stage.world.add(this.view.mesh);

    const { model, snapshot } = stage;
    const forces = (side: "left" | "right") =>
      model !== null && snapshot !== null ? digitForces(model, snapshot, side) : null;
    const seen = SIDES.flatMap((side) => {
      const joints = this.hands.fresh(side);
      return joints === null ? [] : [{ joints, forces: forces(side) }];
    });
    this.view.mesh.visible = stage.layer("tracked");
    if (this.view.mesh.visible) this.view.show(seen);
    const force = (side: "left" | "right") => totalForce(model, snapshot, side);
    this.haptics.update(this.session.inputSources, force, time);
    if (this.recentreGesture.update(this.hands.fresh("left"), this.centre, force("left") > 0, time)) {
      this.recentre();
    }
    if (this.controllers.pressed()) this.recentre();
    const speed = snapshot?.speed ?? null;
    const data = { forces: { left: forces("left"), right: forces("right") }, speed };
    this.panel.draw({ ...data, advice: this.advice(seen.length > 0) }, time);
  }

  private advice(bare: boolean): string {
    const { connection } = this.app;
    if (connection.state !== "open") return "The server does not answer. Waiting for it.";
    if (!connection.inControl) return "Somebody else holds control.";
    if (connection.status?.loading) return "Building hands of your size.";
    if (this.recentreGesture.progress > 0.2) return "Hold on: the scene comes before you.";
    if (!bare && SIDES.some((side) => this.controllers.fresh(side))) {
      return "Trigger: index finger. Grip button: the other fingers. Stick: the scene comes before you.";
    }
    if (!bare) return "Show your hands, or take the controllers.";
    return "Touch what lies before you.";
  }
}
