// Where the simulated world stands before the visitor.
//
// The reference space of WebXR is in metres, +y up, with the floor at y = 0 (local-floor) or the
// origin near the head (local). The world keeps its true scale and stays level. Its +z axis points
// at the visitor; the middle of the scene stands ahead, its table (world y = 0) below the eyes.

import { Quaternion, Vector3 } from "three";
import type { Rigid } from "../tracking/rigid";

/** From the eyes to the middle of the scene, along the ground, m: within reach of both hands. */
export const AHEAD = 0.45;
/** From the eyes down to the table, m: seated, a table of 0.75 m; standing, one to stand at. */
export const BELOW_EYES = 0.42;
/** Lowest table above a known floor, m. */
export const TABLE_MIN = 0.6;

/** Pose of the world in the reference space, from the pose of the head in it. `centre` is the middle
 * of the scene in the world; its height does not matter. */
export function placeWorld(head: Rigid, centre: Vector3, floorKnown: boolean): Rigid {
  const ahead = levelAhead(head.rotation);
  const rotation = new Quaternion().setFromAxisAngle(
    new Vector3(0, 1, 0),
    Math.atan2(-ahead.x, -ahead.z),
  );
  const height = head.position.y - BELOW_EYES;
  const middle = head.position.clone().addScaledVector(ahead, AHEAD);
  middle.y = floorKnown ? Math.max(TABLE_MIN, height) : height;
  const shift = new Vector3(centre.x, 0, centre.z).applyQuaternion(rotation);
  return { position: middle.sub(shift), rotation };
}

/** Where the head looks, along the ground. Looking straight down, the top of the head is ahead. */
function levelAhead(head: Quaternion): Vector3 {
  const ahead = new Vector3(0, 0, -1).applyQuaternion(head);
  const up = new Vector3(0, 1, 0).applyQuaternion(head);
  // Within 10 degrees of straight up or down the look itself says nothing of the direction.
  const down = ahead.y < 0;
  if (Math.hypot(ahead.x, ahead.z) < 0.17) ahead.copy(up).multiplyScalar(down ? 1 : -1);
  ahead.y = 0;
  return ahead.normalize();
}
