// Everything that moves in one scene.

import { Box3, Group, Matrix4, Mesh, Raycaster, Vector3, Vector4, type Camera, type IUniform } from "three";
import type { HandModel, RigidModel, SceneModel, Snapshot, Touch } from "../protocol/types";
import { roundUp } from "./colour-map";
import { ContactView } from "./contact-view";
import { CuffView } from "./cuff-view";
import { fleshBelow } from "./drop-mark";
import { ExoskeletonView } from "./exoskeleton-view";
import { GhostView } from "./ghost-view";
import { Interpolator } from "./interpolate";
import { ON_SKIN, type LayerName } from "./layers";
import type { Shared } from "./materials";
import { PressureMap } from "./pressure";
import { boneView, rayView, RigidView, SHAPELESS } from "./rigid-view";
import { restPoses } from "./skinning";
import { SoftView } from "./soft-view";
import { bonesNamed, surfaceWeights } from "./weights";

/** How far beside the flesh its skinning alone is drawn, m. */
const BESIDE = 0.15;
/** From higher than this, nobody looks for the floor, m. */
const FALL = 0.5;
/** The pressure scale never ends below this, Pa. */
const PRESSURE_LEAST = 2000;

export class WorldView {
  readonly group = new Group();
  readonly interpolator: Interpolator;
  readonly contacts = new ContactView();
  /** End of the pressure scale, Pa. */
  pressureMost = PRESSURE_LEAST;
  private readonly rigids: RigidView[];
  private readonly softs: SoftView[];
  private readonly ghosts: GhostView[] = [];
  /** One for each hand. */
  private readonly exoskeletons: readonly ExoskeletonView[];
  private readonly cuffs: readonly CuffView[];
  private readonly bones: { readonly rigid: number; readonly group: Group }[] = [];
  private readonly extents: readonly (number | null)[];
  private readonly pressures = new Map<number, PressureMap>();
  private layers: ReadonlySet<LayerName> = new Set();
  private snapshot: Snapshot | null = null;
  private fresh = false;
  private peakSince = 0;
  private peak = 0;

  constructor(
    readonly model: SceneModel,
    shared: Shared,
    clip: IUniform,
    private readonly camera: Camera,
  ) {
    this.interpolator = new Interpolator(model);
    this.extents = model.rigids.map(extent);
    this.rigids = model.rigids.map((rigid) => new RigidView(rigid, shared));
    this.softs = model.softs.map((soft) => {
      const hand = soft.hand === null ? null : model.hands[soft.hand];
      return new SoftView(soft, hand, shared, clip);
    });
    for (const body of this.softs) {
      if (body.hand === null || body.model.skin === null) continue;
      for (const of of ["tracked", "skinning"] as const) {
        this.ghosts.push(new GhostView(of, body, body.model.skin, body.hand, shared));
      }
    }
    for (const hand of model.hands) {
      const groups = hand.bones.map((bone, b) =>
        boneView(bone, hand.angles.filter((angle) => angle?.bone === b).length),
      );
      groups.forEach((group, b) => this.bones.push({ rigid: hand.bone_start + b, group }));
      this.drawRays(hand, groups);
    }
    this.exoskeletons = model.hands.map((hand) => new ExoskeletonView(hand));
    this.cuffs = model.hands.flatMap((hand) => (hand.cuff === null ? [] : [new CuffView(hand, hand.cuff)]));
    const things = [...this.rigids, ...this.cuffs, ...this.softs, ...this.ghosts, ...this.bones, ...this.exoskeletons];
    for (const part of [...things, this.contacts]) this.group.add(part.group);
    this.group.visible = false;
  }

  /** Bones of the palm: from the wrist to the first bone of each finger, as the rest shape has them. */
  private drawRays(hand: HandModel, groups: readonly Group[]): void {
    const soft = hand.soft === null ? null : this.model.softs[hand.soft];
    if (soft === null || soft.skin === null) return;
    const poses = restPoses(soft, soft.skin, hand);
    const matrix = (b: number) => {
      const m = poses.subarray(12 * b);
      return new Matrix4().set(
        m[0],
        m[1],
        m[2],
        m[9],
        m[3],
        m[4],
        m[5],
        m[10],
        m[6],
        m[7],
        m[8],
        m[11],
        0,
        0,
        0,
        1,
      );
    };
    hand.bones.forEach((bone, b) => {
      if (bone.parent === null || hand.bones[bone.parent].parent !== null) return;
      const palm = hand.bones[bone.parent];
      const finger = new Vector3(...bone.ends_B[0]).applyMatrix4(matrix(b));
      finger.applyMatrix4(matrix(bone.parent).invert());
      groups[bone.parent].add(rayView(new Vector3(...palm.ends_B[0]), finger, bone.radius));
    });
  }

  push(snapshot: Snapshot): void {
    this.interpolator.push(snapshot);
    this.snapshot = snapshot;
    this.fresh = true;
  }

  setLayers(layers: ReadonlySet<LayerName>): void {
    this.layers = new Set(layers);
    const on = (name: LayerName) => layers.has(name);
    for (const view of this.rigids) view.setVisible(on("objects"), on("wireframe"));
    for (const view of this.softs) {
      const hand = view.hand !== null;
      const through = hand && (on("bones") || on("flesh") || on("pressure"));
      view.setGlow(hand && on("pressure"));
      // Colours on the skin need the skin.
      const coloured = hand && ON_SKIN.some(on);
      const cells = on("flesh") && (hand || !on("objects"));
      view.setVisible(on(hand ? "skin" : "objects") || coloured, through, cells, !hand && on("wireframe"));
    }
    const whole = on("skin") && !on("bones") && !on("flesh") && !on("pressure");
    for (const cuff of this.cuffs) cuff.setVisible(whole);
    for (const ghost of this.ghosts) ghost.setVisible(on(ghost.of));
    for (const bone of this.bones) bone.group.visible = on("bones") || this.boneless(bone.rigid);
    this.contacts.setVisible(on("contacts"), on("forces"));
    this.placeBeside();
    this.fresh = true;
  }

  /** A hand without flesh is its bones. */
  private boneless(rigid: number): boolean {
    return this.model.hands.some(
      (hand) => hand.soft === null && rigid >= hand.bone_start && rigid < hand.bone_start + hand.bone_count,
    );
  }

  /** Skinning stands beside the flesh when both show, to the right of who looks. */
  private placeBeside(): void {
    const right = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0).setY(0);
    if (right.lengthSq() < 1e-6) right.set(1, 0, 0);
    right.setLength(this.layers.has("skin") ? BESIDE : 0);
    for (const ghost of this.ghosts) if (ghost.of === "skinning") ghost.group.position.copy(right);
  }

  /** Draws the tendons of devices that have them, on the first hand of each side, with the forces that they are sent. */
  setTendons(hands: Touch["hands"]): void {
    this.exoskeletons.forEach((exoskeleton, k) => {
      const { side } = this.model.hands[k];
      const first = this.model.hands.findIndex((hand) => hand.side === side) === k;
      const device = hands.find((hand) => first && hand.side === side && hand.renders === "tendons");
      exoskeleton.setForces(device?.sent ?? null, device?.force_max ?? 0);
    });
    this.fresh = true;
  }

  /** Whose skinning weights the layer of that name shows. */
  setWeightBones(names: readonly string[]): void {
    for (const { model, hand, boneWeight } of this.softs) {
      if (hand === null || model.skin === null) continue;
      surfaceWeights(model, model.skin, bonesNamed(hand, names), boneWeight.array as Float32Array);
      boneWeight.needsUpdate = true;
    }
  }

  /** Brings everything to the moment `now`, ms. False if nothing has changed. */
  update(now: number): boolean {
    if (this.snapshot === null) return false;
    const moved = this.interpolator.update(now);
    if (!moved && !this.fresh) return false;
    this.group.visible = true;
    const { rigids, nodes, targets } = this.interpolator;
    for (let i = 0; i < this.rigids.length; i++) {
      if (this.rigids[i].body !== null) this.rigids[i].update(rigids, i);
    }
    for (const view of this.softs) view.update(nodes);
    for (const ghost of this.ghosts) ghost.update(rigids, targets);
    for (const exoskeleton of this.exoskeletons) exoskeleton.update(rigids);
    for (const cuff of this.cuffs) cuff.update(rigids);
    for (const { rigid, group } of this.bones) {
      if (!group.visible) continue;
      group.position.fromArray(rigids, 7 * rigid);
      group.quaternion.fromArray(rigids, 7 * rigid + 3);
    }
    if (this.fresh) {
      this.fresh = false;
      this.contacts.update(this.snapshot, this.model);
      if (this.layers.has("pressure")) this.updatePressure(this.snapshot, now);
    }
    return true;
  }

  private updatePressure(snapshot: Snapshot, now: number): void {
    let peak = 0;
    this.softs.forEach((view, index) => {
      if (view.hand === null) return;
      let map = this.pressures.get(index);
      if (map === undefined) {
        map = new PressureMap(view.model);
        this.pressures.set(index, map);
      }
      peak = Math.max(peak, map.update(snapshot, index, view.pressure.array as Float32Array));
      view.pressure.needsUpdate = true;
    });
    // The scale follows the peak of the last seconds, in steps.
    if (peak > this.peak || now - this.peakSince > 4000) {
      this.peak = peak;
      this.peakSince = now;
    }
    this.pressureMost = Math.max(PRESSURE_LEAST, roundUp(this.peak));
  }

  /** The box around all that moves. */
  bounds(out: Box3): void {
    out.makeEmpty();
    const { nodes, rigids } = this.interpolator;
    for (let i = 0; i < nodes.length; i += 3) out.expandByPoint(POINT.fromArray(nodes, i));
    for (let i = 0; i < this.extents.length; i++) {
      const reach = this.extents[i];
      if (reach === null) continue;
      out.expandByPoint(POINT.fromArray(rigids, 7 * i).addScalar(reach));
      out.expandByPoint(POINT.addScalar(-2 * reach));
    }
    if (out.isEmpty()) out.copy(NOTHING);
  }

  /** Height of the surface straight below a place, world frame, m: of objects, flesh of no hand and planes that lie
   * level, as those of tables do; null if there is none. */
  surfaceBelow(from: Vector3): number | null {
    const heights: number[] = [];
    const { nodes, rigids } = this.interpolator;
    for (const { hand, model } of this.softs) {
      const start = model.node_start;
      const top = hand === null ? fleshBelow(from, nodes, start, start + model.nodes.length / 3) : null;
      if (top !== null) heights.push(top);
    }
    const world = this.group.matrixWorld;
    DOWN.set(from.clone().applyMatrix4(world), new Vector3(0, -1, 0).transformDirection(world));
    this.rigids.forEach(({ body, model: { kind } }, i) => {
      const height = rigids[7 * i + 1];
      if (kind === "plane" && height < from.y) heights.push(height);
      const [hit] = kind === "none" || body === null ? [] : DOWN.intersectObject(body, false);
      if (hit !== undefined) heights.push(this.group.worldToLocal(hit.point.clone()).y);
    });
    return heights.length === 0 ? null : Math.max(...heights);
  }

  /** Where the hands' bones are. */
  handPlaces(): Vector3[] {
    return this.model.hands.flatMap(({ bones, bone_start }) =>
      bones.map((_, b) => new Vector3().fromArray(this.interpolator.rigids, 7 * (bone_start + b))),
    );
  }

  /** What a first look should hold: the content, and the way down to a floor beneath it. */
  scope(): Box3 {
    const box = new Box3();
    this.bounds(box);
    const middle = box.getCenter(new Vector3());
    this.model.rigids.forEach(({ kind }, i) => {
      const floor = this.interpolator.rigids[7 * i + 1];
      const beneath = kind === "plane" && floor < box.min.y && box.min.y - floor < FALL;
      if (beneath) box.expandByPoint(middle.setY(floor));
    });
    return box;
  }

  /** Moves a box along with the content, smoothly, and grows it where content leaves it. */
  follow(box: Box3): void {
    this.bounds(NOW);
    box.min.lerp(NOW.min, 0.1);
    box.max.lerp(NOW.max, 0.1);
  }

  clipPlane(axis: "x" | "y" | "z" | null, part: number): Vector4 | null {
    if (axis === null) return null;
    const c = "xyz".indexOf(axis);
    let [low, high] = [Infinity, -Infinity];
    for (const { model } of this.softs) {
      for (let i = c; i < model.nodes.length; i += 3) {
        low = Math.min(low, model.nodes[i]);
        high = Math.max(high, model.nodes[i]);
      }
    }
    const plane = new Vector4(0, 0, 0, low + part * (high - low));
    plane.setComponent(c, 1);
    return plane;
  }

  dispose(): void {
    for (const part of [...this.rigids, ...this.softs, ...this.ghosts, ...this.exoskeletons]) part.dispose();
    this.group.traverse((part) => {
      if (!(part instanceof Mesh)) return;
      part.geometry.dispose();
      for (const material of [part.material].flat()) material.dispose();
    });
  }
}

const NOW = new Box3();
const DOWN = new Raycaster();
const POINT = new Vector3();
/** What to look at where nothing moves. */
const NOTHING = new Box3(new Vector3(-0.1, 0, -0.1), new Vector3(0.1, 0.1, 0.1));

/** How far a rigid body reaches from its origin, m; null for what has no end or no shape. */
function extent(rigid: RigidModel): number | null {
  if (rigid.kind === "plane") return null;
  if (rigid.kind === "none") return rigid.fixed ? null : SHAPELESS;
  if (rigid.mesh !== null) {
    const { positions } = rigid.mesh;
    let square = 0;
    for (let i = 0; i < positions.length; i += 3) {
      square = Math.max(square, positions[i] ** 2 + positions[i + 1] ** 2 + positions[i + 2] ** 2);
    }
    return Math.sqrt(square);
  }
  if (rigid.parts.length > 0) {
    const [x, y, z] = rigid.pose_BS;
    const reach = (part: RigidModel) =>
      (extent(part) ?? 0) + Math.hypot(part.pose_BS[0] - x, part.pose_BS[1] - y, part.pose_BS[2] - z);
    return Math.max(...rigid.parts.map(reach));
  }
  return rigid.half === null ? (rigid.radius ?? 0) + (rigid.half_length ?? 0) : Math.hypot(...rigid.half);
}
