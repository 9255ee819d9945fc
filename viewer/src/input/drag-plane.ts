// Where a dragged hand goes: along a plane through the grabbed point, so that the point stays under
// the pointer. The plane stands upright and faces the camera, or lies level; a plane that the camera
// looks along is useless, and the plane of the picture takes its place.

import { Ray, Vector3 } from "three";

/** Upright: the hand goes up, down and sideways, no nearer. Level: it keeps its height. */
export type DragKind = "upright" | "level";

/** Below this sine between view and plane (20 degrees) one pixel would move the hand too far. */
const SINE_LEAST = Math.sin((20 * Math.PI) / 180);
/** One event moves the hand no farther than this: pointers leap at the horizon, m. */
const STEP_MOST = 0.3;

const UP = new Vector3(0, 1, 0);

/** Unit normal of the plane, world frame; `view` is the unit direction from the camera to the hand. */
export function dragNormal(kind: DragKind, view: Vector3): Vector3 {
  const normal = kind === "level" ? UP.clone() : view.clone().setY(0);
  if (normal.lengthSq() < 1e-9) return view.clone();
  normal.normalize();
  return Math.abs(normal.dot(view)) < SINE_LEAST ? view.clone() : normal;
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
