// What a dragged hand is above: a line straight down through where it would hold something, and a ring where
// the line meets a surface. A picture shows up, down and sideways; this shows how far away the hand is.

import { CylinderGeometry, Group, Mesh, MeshBasicMaterial, RingGeometry, Vector3 } from "three";

/** Radius of the line, m. */
const LINE = 0.0008;
/** Inner and outer radius of the ring, m: a fingertip's. */
const RING = [0.0065, 0.0085] as const;
/** The ring lies so far above the surface, so that it is not in it, m. */
const ABOVE = 0.001;
const COLOUR = 0x1f8fff;

export class DropMark {
  readonly group = new Group();
  private readonly line: Mesh;
  private readonly ring: Mesh;

  constructor() {
    const material = new MeshBasicMaterial({ color: COLOUR, toneMapped: false });
    // One metre long from its lower end, and scaled.
    this.line = new Mesh(new CylinderGeometry(LINE, LINE, 1, 8).translate(0, 0.5, 0), material);
    this.ring = new Mesh(new RingGeometry(...RING, 32).rotateX(-Math.PI / 2), material);
    this.group.add(this.line, this.ring);
    this.group.visible = false;
  }

  /** From a place down to a height, world frame, m; hidden where there is nothing beneath. */
  show(from: Vector3 | null, height: number | null): void {
    this.group.visible = from !== null && height !== null && height < from.y;
    if (from === null || height === null) return;
    this.group.position.set(from.x, height, from.z);
    this.line.scale.y = Math.max(1e-6, from.y - height);
    this.ring.position.y = ABOVE;
  }
}

/** Nodes this near to the vertical count, m: half the diagonal of a cell of the loaf is 13 mm. */
const NODE_REACH = 0.015;

/** The highest node of flesh near the vertical through a place and below it, m; null if there is none. */
export function fleshBelow(from: Vector3, nodes: Float32Array, start: number, end: number): number | null {
  let top: number | null = null;
  for (let n = start; n < end; n++) {
    const [x, y, z] = [nodes[3 * n], nodes[3 * n + 1], nodes[3 * n + 2]];
    if (y > from.y || (top !== null && y <= top)) continue;
    if (Math.hypot(x - from.x, z - from.z) < NODE_REACH) top = y;
  }
  return top;
}
