// Rigid bodies: primitives, painted meshes, and the bones of hands.

import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  Color,
  CylinderGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshStandardMaterial,
  Quaternion,
  SphereGeometry,
  Vector3,
  WireframeGeometry,
} from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { HandBone, RigidModel } from "../protocol/types";
import { paintMaterial, type Shared } from "./materials";
import { linearColours } from "./soft-view";
import { vertexNormals } from "./surface";

const PAINT = new Color(0.62, 0.45, 0.28).convertSRGBToLinear();

export class RigidView {
  readonly group = new Group();
  readonly body: Mesh | null;
  private wire: LineSegments | null = null;

  constructor(
    readonly model: RigidModel,
    shared: Shared,
  ) {
    const geometry = shape(model);
    if (geometry === null) {
      this.body = null;
      return;
    }
    const colour = model.colour === null ? PAINT : new Color(...model.colour).convertSRGBToLinear();
    const painted = geometry.hasAttribute("color");
    this.body = new Mesh(geometry, paintMaterial(colour, painted, shared));
    this.body.castShadow = this.body.receiveShadow = true;
    if (model.mesh === null && model.parts.length === 0) {
      // Primitives are given in the shape's frame, meshes and parts in the body's.
      this.body.position.fromArray(model.pose_BS);
      this.body.quaternion.fromArray(model.pose_BS, 3);
    }
    this.group.add(this.body);
  }

  setVisible(body: boolean, wire: boolean): void {
    if (this.body === null) return;
    this.body.visible = body;
    if (wire && this.wire === null) {
      this.wire = new LineSegments(
        new WireframeGeometry(this.body.geometry),
        new LineBasicMaterial({ color: 0xd7e3ee, transparent: true, opacity: 0.65 }),
      );
      this.wire.position.copy(this.body.position);
      this.wire.quaternion.copy(this.body.quaternion);
      this.group.add(this.wire);
    }
    if (this.wire !== null) this.wire.visible = wire;
  }

  update(rigids: Float32Array, index: number): void {
    this.group.position.fromArray(rigids, 7 * index);
    this.group.quaternion.fromArray(rigids, 7 * index + 3);
  }

  dispose(): void {
    this.body?.geometry.dispose();
    this.wire?.geometry.dispose();
  }
}

function shape(model: RigidModel): BufferGeometry | null {
  if (model.mesh !== null) {
    const { positions, triangles, colours } = model.mesh;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(vertexNormals(positions, triangles), 3));
    geometry.setIndex(new BufferAttribute(triangles, 1));
    if (colours !== null) geometry.setAttribute("color", linearColours(colours));
    return creased(geometry);
  }
  switch (model.kind) {
    case "cylinder": {
      const radius = model.radius ?? 0.01;
      return new CylinderGeometry(radius, radius, 2 * (model.half_length ?? 0.01), 64);
    }
    case "cone": {
      // The origin is the centre of mass: a quarter of the height above the base.
      const half = model.half_length ?? 0.01;
      return new CylinderGeometry(0, model.radius ?? 0.01, 2 * half, 64).translate(0, 0.5 * half, 0);
    }
    case "ellipsoid": {
      const [x, y, z] = model.half ?? [0.01, 0.01, 0.01];
      return new SphereGeometry(1, 48, 24).scale(x, y, z);
    }
    case "compound":
      return together(model.parts);
    case "box": {
      const [x, y, z] = model.half ?? [0.01, 0.01, 0.01];
      return new BoxGeometry(2 * x, 2 * y, 2 * z);
    }
    case "sphere":
      return new SphereGeometry(model.radius ?? 0.01, 48, 24);
    case "capsule":
      return new CapsuleGeometry(model.radius ?? 0.01, 2 * (model.half_length ?? 0.01), 12, 32);
    case "none":
      // A body of mass alone moves too: a thin cross along its axes.
      return cross(SHAPELESS, model.fixed);
    default:
      return null;
  }
}

/** The parts of a compound in one geometry, in the body's frame. */
function together(parts: readonly RigidModel[]): BufferGeometry | null {
  const placed = parts.flatMap((part) => {
    const geometry = shape(part);
    if (geometry === null) return [];
    if (part.mesh === null) {
      geometry.applyQuaternion(new Quaternion().fromArray(part.pose_BS, 3));
      const [x, y, z] = part.pose_BS;
      geometry.translate(x, y, z);
    }
    // Merging needs the same attributes in each.
    const single = geometry.index === null ? geometry : geometry.toNonIndexed();
    single.deleteAttribute("uv");
    return [single];
  });
  return placed.length === 0 ? null : mergeGeometries(placed);
}

/** Half the size of what stands for a body without a shape, m. */
export const SHAPELESS = 0.009;

function cross(half: number, fixed: boolean): BufferGeometry | null {
  if (fixed) return null;
  const thin = 0.1 * half;
  const bars = [0, 1, 2].map((axis) => {
    const size = [thin, thin, thin].map((t, i) => 2 * (i === axis ? half : t));
    return new BoxGeometry(size[0], size[1], size[2]);
  });
  return mergeGeometries(bars);
}

/** Own normals for the corners of triangles that stand at more than this to the smooth normal. */
const CREASE = Math.cos((38 * Math.PI) / 180);

/** Keeps edges sharp: made of single triangles whose corners share a normal only across soft bends. */
function creased(smooth: BufferGeometry): BufferGeometry {
  const geometry = smooth.toNonIndexed();
  const position = geometry.getAttribute("position");
  const normal = geometry.getAttribute("normal");
  const [a, b, c, n, face] = [0, 1, 2, 3, 4].map(() => new Vector3());
  for (let v = 0; v < position.count; v += 3) {
    a.fromBufferAttribute(position, v);
    b.fromBufferAttribute(position, v + 1).sub(a);
    c.fromBufferAttribute(position, v + 2).sub(a);
    face.crossVectors(b, c).normalize();
    for (let k = 0; k < 3; k++) {
      n.fromBufferAttribute(normal, v + k);
      if (n.dot(face) < CREASE) normal.setXYZ(v + k, face.x, face.y, face.z);
    }
  }
  return geometry;
}

const BONE = new MeshStandardMaterial({ color: 0xe9dfc8, roughness: 0.55 });
/** Joints as in the paper's Fig. 2: those with one angle blue, those with two red. */
export const JOINT_COLOURS = { hinge: "#2f6fe4", universal: "#d8382e" } as const;
const HINGE = new MeshStandardMaterial({ color: JOINT_COLOURS.hinge, roughness: 0.4 });
const UNIVERSAL = new MeshStandardMaterial({ color: JOINT_COLOURS.universal, roughness: 0.4 });

/** A bone between its ends, its head at the joint with the bone before it, and that joint's axis;
 * `angles`: how many that joint has. */
export function boneView(bone: HandBone, angles: number): Group {
  const joint = angles > 1 ? UNIVERSAL : HINGE;
  const group = new Group();
  const [from, to] = bone.ends_B.map((end) => new Vector3(...end));
  const along = new Vector3().subVectors(to, from);
  const length = along.length();
  const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), along.clone().normalize());
  const radius = bone.radius;
  const shaft = new Mesh(new CylinderGeometry(0.62 * radius, 0.72 * radius, length, 20, 1), BONE);
  shaft.position.addVectors(from, to).multiplyScalar(0.5);
  shaft.quaternion.copy(turn);
  const head = new Mesh(new SphereGeometry(radius, 20, 14), BONE);
  head.position.copy(to);
  head.scale.setScalar(0.82);
  const base = new Mesh(new SphereGeometry(radius, 20, 14), bone.parent === null ? BONE : joint);
  base.position.copy(from);
  base.scale.setScalar(bone.parent === null ? 1 : 1.15);
  // The palm's one body stands for several bones; rays show them.
  if (bone.parent === null) group.add(base);
  else {
    group.add(shaft, head, base);
    // Bones bend about their x axis.
    const axis = new Mesh(new CylinderGeometry(0.0006, 0.0006, 6 * radius, 8), joint);
    axis.position.copy(from);
    axis.rotation.z = Math.PI / 2;
    group.add(axis);
  }
  group.traverse((part) => (part.castShadow = true));
  return group;
}

/** A thin bone in the palm, from the wrist to where a finger begins, in the palm's frame. */
export function rayView(wrist: Vector3, finger: Vector3, radius: number): Mesh {
  const along = new Vector3().subVectors(finger, wrist);
  const from = new Vector3().copy(wrist).addScaledVector(along, 0.16);
  const ray = new Mesh(new CylinderGeometry(0.8 * radius, 0.66 * radius, 0.8 * along.length(), 16, 1), BONE);
  ray.position.addVectors(from, finger).multiplyScalar(0.5);
  ray.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), along.normalize());
  ray.castShadow = true;
  return ray;
}
