// From what WebXR fills (column-major matrices, radii) to the numbers of a `joints` message.

import { Matrix4, Quaternion } from "three";
import { JOINTS, JOINT_NUMBERS, type HandJoints } from "./joints";

const matrix = new Matrix4();
const rotation = new Quaternion();

/** `matrices`: 16 numbers per joint, rigid, as of XRFrame.fillPoses; `radii`: one per joint, m.
 * False, and `out` untouched, if a number is not finite. Allocates nothing. */
export function packJoints(matrices: Float32Array, radii: Float32Array, out: HandJoints): boolean {
  if (!allFinite(matrices) || !allFinite(radii)) return false;
  for (let joint = 0; joint < JOINTS; joint++) {
    const at = JOINT_NUMBERS * joint;
    matrix.fromArray(matrices, 16 * joint);
    rotation.setFromRotationMatrix(matrix).normalize().toArray(out, at + 3);
    out[at] = matrix.elements[12];
    out[at + 1] = matrix.elements[13];
    out[at + 2] = matrix.elements[14];
    out[at + 7] = radii[joint];
  }
  return true;
}

function allFinite(numbers: Float32Array): boolean {
  for (let i = 0; i < numbers.length; i++) if (!Number.isFinite(numbers[i])) return false;
  return true;
}
