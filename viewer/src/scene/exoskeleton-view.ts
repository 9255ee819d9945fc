// What a CyberGrasp adds to a hand (the paper's Fig. 1, right): a plate on its back, a tendon to each fingertip, and guides
// that hold the tendon off the finger. A tendon under force is thicker and warmer.

import {
  Color,
  CylinderGeometry,
  Group,
  Mesh,
  MeshStandardMaterial,
  Quaternion,
  SphereGeometry,
  TorusGeometry,
  Vector3,
} from "three";
import { RoundedBoxGeometry } from "three/examples/jsm/geometries/RoundedBoxGeometry.js";
import { DIGITS, type HandModel } from "../protocol/types";

/** How far above a bone's surface the skin of a finger's back lies, and a guide's ring above that, m. */
const SKIN = 0.004;
const GUIDE = 0.014;
/** The plate: above the wrist frame's plane, its size across and along, m. */
const PLATE_HEIGHT = 0.03;
const PLATE: readonly [number, number, number] = [0.058, 0.006, 0.05];
/** From the wrist to the middle of the plate, in parts of the hand's length. */
const PLATE_AHEAD = 0.25;
/** Radii of a slack tendon and of one with full force, m. */
const SLACK = 0.0007;
const TAUT = 0.0018;

/** Thumb first. */
const FINGERS = DIGITS.filter((digit) => digit !== "palm");
const SLACK_COLOUR = new Color(0x9aa3ad);
const TAUT_COLOUR = new Color(0xff5a1f);
const METAL = new MeshStandardMaterial({ color: 0x4a525c, roughness: 0.45, metalness: 0.6 });

/** A point that is fixed to a bone, and the guide that stands there. */
interface Guide {
  readonly bone: number;
  /** Along the bone from its base, 0 to 1, and above its middle line, m. */
  readonly part: number;
  readonly height: number;
  readonly post: Mesh;
}

interface Tendon {
  readonly digit: number;
  readonly guides: readonly Guide[];
  readonly segments: readonly Mesh[];
  readonly material: MeshStandardMaterial;
  /** Part of the largest force, 0 to 1. */
  pull: number;
}

/** Part of the largest force with which each finger is pulled, 0 to 1; what is no number pulls nothing. */
export function pulls(sent: readonly number[], most: number): number[] {
  return sent.map((force) => (most > 0 && Number.isFinite(force) ? Math.min(1, Math.max(0, force / most)) : 0));
}

export class ExoskeletonView {
  readonly group = new Group();
  private readonly plate = new Mesh(new RoundedBoxGeometry(...PLATE, 3, 0.002), METAL);
  private readonly tendons: readonly Tendon[];
  /** Which way along its z axis a finger's bone has its back; 0 until that is known. */
  private back = 0;

  constructor(private readonly hand: HandModel) {
    this.group.add(this.plate);
    this.tendons = FINGERS.map((_, digit) => this.tendon(digit));
    this.group.traverse((part) => (part.castShadow = true));
    this.group.visible = false;
  }

  private tendon(digit: number): Tendon {
    const bones = this.hand.bones.flatMap((bone, b) => (bone.parent !== null && bone.digit === FINGERS[digit] ? [b] : []));
    const material = new MeshStandardMaterial({ color: SLACK_COLOUR, roughness: 0.4 });
    const guides = bones.map((bone, k): Guide => {
      const last = k === bones.length - 1;
      const ring = new Mesh(new TorusGeometry(0.0024, 0.0008, 8, 16), METAL);
      const height = this.hand.bones[bone].radius + SKIN + (last ? 0 : GUIDE);
      // At the tip the tendon ends on a cap; before it runs through rings on posts.
      const post = new Mesh(
        last ? new SphereGeometry(0.0035, 16, 12) : new CylinderGeometry(0.0011, 0.0016, GUIDE, 10),
        METAL,
      );
      if (!last) {
        ring.position.y = GUIDE / 2;
        post.add(ring);
      }
      this.group.add(post);
      return { bone, part: last ? 0.8 : 0.5, height, post };
    });
    const segments = guides.map(() => {
      const segment = new Mesh(new CylinderGeometry(1, 1, 1, 10), material);
      this.group.add(segment);
      return segment;
    });
    return { digit, guides, segments, material, pull: 0 };
  }

  /** Shows these forces, thumb first, N, of at most `most`; nothing without them. */
  setForces(sent: readonly number[] | null, most: number): void {
    this.group.visible = sent !== null;
    const all = pulls(sent ?? [], most);
    for (const tendon of this.tendons) {
      tendon.pull = all[tendon.digit] ?? 0;
      tendon.material.color.lerpColors(SLACK_COLOUR, TAUT_COLOUR, tendon.pull);
    }
  }

  /** Follows the bones: poses of all rigid bodies, seven numbers each. */
  update(rigids: Float32Array): void {
    if (!this.group.visible) return;
    const palm = this.hand.bones.findIndex((bone) => bone.parent === null);
    const place = (b: number) => {
      const at = 7 * (this.hand.bone_start + b);
      POSITION.fromArray(rigids, at);
      TURN.fromArray(rigids, at + 3);
    };
    place(palm);
    const [x, y, z, ...turn] = this.hand.wrist_B;
    WRIST.set(x, y, z).applyQuaternion(TURN).add(POSITION);
    WRIST_TURN.copy(TURN).multiply(QUARTER.fromArray(turn));
    UP.set(0, 1, 0).applyQuaternion(WRIST_TURN);
    AHEAD.set(0, 0, -1).applyQuaternion(WRIST_TURN);
    this.plate.position
      .copy(WRIST)
      .addScaledVector(UP, PLATE_HEIGHT)
      .addScaledVector(AHEAD, PLATE_AHEAD * this.hand.length);
    this.plate.quaternion.copy(WRIST_TURN);
    this.back ||= this.findBack(place);
    for (const tendon of this.tendons) this.draw(tendon, place);
  }

  /** Bones of fingers have their back along z, one way or the other: the one in which most look up as the hand does. */
  private findBack(place: (b: number) => void): number {
    let sum = 0;
    this.hand.bones.forEach(({ parent, digit }, b) => {
      if (parent === null || digit === "thumb" || this.hand.bones[parent].parent !== null) return;
      place(b);
      sum += BACK.set(0, 0, 1).applyQuaternion(TURN).dot(UP);
    });
    return sum < 0 ? -1 : 1;
  }

  private draw({ digit, guides, segments, pull }: Tendon, place: (b: number) => void): void {
    const radius = SLACK + (TAUT - SLACK) * pull;
    // From the plate's front edge, side by side, the thumb's from its side.
    const across = (this.hand.side === "left" ? 1 : -1) * (digit === 0 ? 0.5 : 0.36 - 0.24 * (digit - 1));
    FROM.set(across * PLATE[0], 0, digit === 0 ? 0 : -PLATE[2] / 2)
      .applyQuaternion(this.plate.quaternion)
      .add(this.plate.position);
    guides.forEach(({ bone, part, height, post }, k) => {
      place(bone);
      const [base, end] = this.hand.bones[bone].ends_B;
      BACK.set(0, 0, this.back).applyQuaternion(TURN);
      MIDDLE.set(...base)
        .lerp(END.set(...end), part)
        .applyQuaternion(TURN)
        .add(POSITION);
      TO.copy(MIDDLE).addScaledVector(BACK, height);
      const last = k === guides.length - 1;
      post.position.copy(TO).addScaledVector(BACK, last ? 0 : -GUIDE / 2);
      // Its length is along its y axis; its ring looks along the finger.
      post.quaternion.copy(TURN).multiply(QUARTER.setFromAxisAngle(X, (this.back * Math.PI) / 2));
      stretch(segments[k], FROM, TO, radius);
      FROM.copy(TO);
    });
  }

  dispose(): void {
    for (const { material } of this.tendons) material.dispose();
  }
}

/** Lays a cylinder of height one between two points. */
function stretch(segment: Mesh, from: Vector3, to: Vector3, radius: number): void {
  ALONG.subVectors(to, from);
  const length = ALONG.length();
  segment.position.addVectors(from, to).multiplyScalar(0.5);
  segment.scale.set(radius, Math.max(length, 1e-6), radius);
  if (length > 0) segment.quaternion.setFromUnitVectors(Y, ALONG.divideScalar(length));
}

const X = new Vector3(1, 0, 0);
const Y = new Vector3(0, 1, 0);
const POSITION = new Vector3();
const TURN = new Quaternion();
const QUARTER = new Quaternion();
const WRIST = new Vector3();
const WRIST_TURN = new Quaternion();
const UP = new Vector3();
const AHEAD = new Vector3();
const BACK = new Vector3();
const MIDDLE = new Vector3();
const END = new Vector3();
const FROM = new Vector3();
const TO = new Vector3();
const ALONG = new Vector3();
