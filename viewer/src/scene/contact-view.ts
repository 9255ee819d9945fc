// Contact points, and arrows for the normal and the frictional part of each force.

import {
  Color,
  ConeGeometry,
  CylinderGeometry,
  Group,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  Quaternion,
  SphereGeometry,
  Vector3,
  type BufferGeometry,
} from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { SOFT_BODY, type SceneModel, type Snapshot } from "../protocol/types";
import { roundUp } from "./colour-map";

const MOST = 512;
/** The longest arrow, m. */
const LONGEST = 0.05;
/** Slip above which a point counts as sliding, m/s. */
const SLIDING = 1e-3;

export const CONTACT_COLOURS = {
  sticking: "#4fd1a5",
  sliding: "#ff8a3d",
  normal: "#58b7ff",
  shear: "#ff4f81",
};

export class ContactView {
  readonly points = instances(new SphereGeometry(0.0011, 10, 8));
  readonly normals = instances(arrow());
  readonly shears = instances(arrow());
  readonly group = new Group();
  /** Force of the longest arrow, N. */
  forceMost = 1;
  private readonly stick = new Color(CONTACT_COLOURS.sticking);
  private readonly slide = new Color(CONTACT_COLOURS.sliding);

  constructor() {
    this.normals.material = overlay(CONTACT_COLOURS.normal);
    this.shears.material = overlay(CONTACT_COLOURS.shear);
    this.points.material = overlay("#ffffff");
    this.group.add(this.points, this.normals, this.shears);
  }

  setVisible(points: boolean, forces: boolean): void {
    this.points.visible = points;
    this.normals.visible = this.shears.visible = forces;
  }

  update(snapshot: Snapshot, model: SceneModel): void {
    if (!this.points.visible && !this.normals.visible) return;
    const { contacts } = snapshot;
    let most = 0;
    for (let i = 0; i < contacts.count; i++) most = Math.max(most, Math.abs(contacts.normalForce(i)));
    this.rescale(most);
    const scale = LONGEST / this.forceMost;
    for (let i = 0; i < contacts.count; i++) {
      contacts.place(i, PLACE);
      contacts.force(i, SHEAR);
      contacts.normal(i, NORMAL);
      NORMAL.multiplyScalar(contacts.normalForce(i));
      SHEAR.sub(NORMAL);
      // Arrows show the force on the hand, which pushes into its skin.
      if (!isHand(model, contacts.bodyA(i)) && isHand(model, contacts.bodyB(i))) {
        NORMAL.negate();
        SHEAR.negate();
      }
      this.points.setMatrixAt(i, MATRIX.makeTranslation(PLACE));
      this.points.setColorAt(i, contacts.slip(i) > SLIDING ? this.slide : this.stick);
      put(this.normals, i, NORMAL, scale);
      put(this.shears, i, SHEAR, scale);
    }
    for (const mesh of [this.points, this.normals, this.shears]) {
      mesh.count = contacts.count;
      mesh.instanceMatrix.needsUpdate = true;
    }
    if (this.points.instanceColor !== null) this.points.instanceColor.needsUpdate = true;
  }

  /** Scales step up at once and down only when forces have become much smaller. */
  private rescale(most: number): void {
    if (most > this.forceMost || most < 0.25 * this.forceMost) this.forceMost = Math.max(0.02, roundUp(most));
  }
}

const PLACE = new Vector3();
const NORMAL = new Vector3();
const SHEAR = new Vector3();
const SIDE = new Vector3();
const UP = new Vector3(0, 1, 0);
const MATRIX = new Matrix4();
const TURN = new Quaternion();
const SIZE = new Vector3();

function isHand(model: SceneModel, body: number): boolean {
  return body >= SOFT_BODY && model.softs[body - SOFT_BODY]?.hand != null;
}

function put(mesh: InstancedMesh, i: number, force: Vector3, scale: number): void {
  const length = force.length() * scale;
  if (length < 2e-4) {
    mesh.setMatrixAt(i, MATRIX.makeScale(0, 0, 0));
    return;
  }
  TURN.setFromUnitVectors(UP, SIDE.copy(force).normalize());
  const thick = Math.min(1, 0.35 + length / 0.02);
  mesh.setMatrixAt(i, MATRIX.compose(PLACE, TURN, SIZE.set(thick, length, thick)));
}

function instances(geometry: BufferGeometry): InstancedMesh {
  const mesh = new InstancedMesh(geometry, undefined, MOST);
  mesh.count = 0;
  mesh.frustumCulled = false;
  mesh.visible = false;
  mesh.renderOrder = 10;
  return mesh;
}

/** Seen through everything: contacts lie between two bodies. */
function overlay(colour: string): MeshBasicMaterial {
  return new MeshBasicMaterial({
    color: colour,
    depthTest: false,
    transparent: true,
    opacity: 0.92,
    toneMapped: false,
  });
}

/** One long along y. */
function arrow(): BufferGeometry {
  const shaft = new CylinderGeometry(0.00045, 0.00045, 0.8, 8).translate(0, 0.4, 0);
  const head = new ConeGeometry(0.0013, 0.2, 12).translate(0, 0.9, 0);
  const whole = mergeGeometries([shaft, head]);
  if (whole === null) throw new Error("An arrow is two shapes.");
  return whole;
}
