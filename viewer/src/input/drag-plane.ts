// Where a dragged hand goes: along a plane through the grabbed point, so that the point stays under
// the pointer. The plane stands upright and faces the camera, or lies level; a plane that the camera
// looks along is useless, and the plane of the picture takes its place. An upright plane leans a
// little where something to hold is under the hand, so that the way down leads to it: depth is what
// a picture shows badly and a drag cannot give.

import { Ray, Vector3 } from "three";

/** Upright: the hand goes up, down and sideways, no nearer. Level: it keeps its height. */
export type DragKind = "upright" | "level";

/** Below this sine between view and plane (20 degrees) one pixel would move the hand too far. */
const SINE_LEAST = Math.sin((20 * Math.PI) / 180);
/** One event moves the hand no farther than this: pointers leap at the horizon, m. */
const STEP_MOST = 0.3;

/** A hand this near to the plane through the thing needs no help: a finger's breadth, m. */
const DEPTH_ENOUGH = 0.02;
/** The plane leans no farther than 30 degrees: a tangent. */
const LEAN_MOST = Math.tan(Math.PI / 6);
/** From this little above the thing the hand is at it already, m: a finger's breadth. */
const DROP_LEAST = 0.02;

const UP = new Vector3(0, 1, 0);

/** Unit normal of the plane, world frame; `view` is the unit direction from the camera to the hand. */
export function dragNormal(kind: DragKind, view: Vector3, lean = 0): Vector3 {
  const normal = kind === "level" ? UP.clone() : view.clone().setY(0);
  if (normal.lengthSq() < 1e-9) return view.clone();
  normal.normalize();
  const leaned = kind === "level" || lean === 0 ? normal : normal.clone().addScaledVector(UP, lean).normalize();
  const useful = [leaned, normal].find((plane) => Math.abs(plane.dot(view)) >= SINE_LEAST);
  return useful?.clone() ?? view.clone();
}

/** How far away from the camera the plane of a drag leads per metre down, m: towards the nearest of `things` under
 * the place `hold`, within a cone of 45 degrees; 0 where none is, or where no help is needed. */
export function leanTowards(hold: Vector3, things: readonly Vector3[], view: Vector3): number {
  const away = view.clone().setY(0);
  if (away.lengthSq() < 1e-9) return 0;
  away.normalize();
  const under = things
    .map((thing) => thing.clone().sub(hold))
    .filter((way) => -way.y > DROP_LEAST && Math.hypot(way.x, way.z) < -way.y)
    .sort((a, b) => a.length() - b.length());
  if (under.length === 0) return 0;
  const [way] = under;
  const depth = way.dot(away);
  const lacking = Math.sign(depth) * Math.max(0, Math.abs(depth) - DEPTH_ENOUGH);
  return Math.min(LEAN_MOST, Math.max(-LEAN_MOST, lacking / -way.y));
}

/** How far a point of the plane moves when the pointer's ray goes from `before` to `after`, m; null
 * where a ray misses the plane. */
export function dragStep(before: Ray, after: Ray, through: Vector3, normal: Vector3): Vector3 | null {
  const meet = (ray: Ray): Vector3 | null => {
    const across = ray.direction.dot(normal);
    if (Math.abs(across) < 1e-6) return null;
    const along = through.clone().sub(ray.origin).dot(normal) / across;
    return along > 0 ? ray.at(along, new Vector3()) : null;
  };
  const [from, to] = [meet(before), meet(after)];
  if (from === null || to === null) return null;
  return to.sub(from).clampLength(0, STEP_MOST);
}
