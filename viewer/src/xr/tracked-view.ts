// The visitor's own hands as tracked: a small sphere per joint, at a part of the joint's radius. The
// fingertips turn from yellow to red with the force that the simulated finger presses with.

import { Color, IcosahedronGeometry, InstancedMesh, Matrix4, MeshStandardMaterial } from "three";
import { DIGIT_JOINTS, JOINTS, JOINT_NUMBERS, type HandJoints } from "../tracking/joints";
import { forceShare } from "./forces";

/** Of the joint's radius: the simulated hand stays visible around it. */
const PART = 0.35;
const CALM = new Color(0xf2c230);
const PRESSED = new Color(0xe02020);

export class TrackedView {
  readonly mesh: InstancedMesh;
  private readonly matrix = new Matrix4();
  private readonly colour = new Color();

  constructor() {
    const material = new MeshStandardMaterial({ roughness: 0.6, depthTest: false, transparent: true });
    this.mesh = new InstancedMesh(new IcosahedronGeometry(1, 1), material, 2 * JOINTS);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 10;
    this.mesh.count = 0;
    for (let i = 0; i < 2 * JOINTS; i++) this.mesh.setColorAt(i, CALM);
  }

  /** Hands that are seen, in the world frame, and the normal force per digit, palm first, N. */
  show(hands: readonly { joints: HandJoints; forces: readonly number[] | null }[]): void {
    let instance = 0;
    for (const { joints, forces } of hands) {
      for (let joint = 0; joint < JOINTS; joint++) {
        const at = JOINT_NUMBERS * joint;
        const size = PART * joints[at + 7];
        this.matrix.makeScale(size, size, size).setPosition(joints[at], joints[at + 1], joints[at + 2]);
        this.mesh.setMatrixAt(instance, this.matrix);
        const share = forceShare(forces?.[tipDigit(joint)] ?? 0);
        this.mesh.setColorAt(instance, this.colour.lerpColors(CALM, PRESSED, share));
        instance += 1;
      }
    }
    this.mesh.count = instance;
    this.mesh.instanceMatrix.needsUpdate = true;
    if (this.mesh.instanceColor !== null) this.mesh.instanceColor.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.geometry.dispose();
    (this.mesh.material as MeshStandardMaterial).dispose();
    this.mesh.dispose();
  }
}

/** Index into the forces of the digit this is the tip of; -1 for other joints. */
function tipDigit(joint: number): number {
  const digit = DIGIT_JOINTS.findIndex((joints) => joints[joints.length - 1] === joint);
  return digit < 0 ? -1 : digit + 1;
}
