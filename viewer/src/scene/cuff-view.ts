// The cuff that a hand wears where its flesh ends.

import { BufferAttribute, BufferGeometry, Color, Group, Mesh, MeshStandardMaterial } from "three";
import type { HandModel, RigidMesh } from "../protocol/types";

const CLOTH = new Color(0x39485a);

export class CuffView {
  readonly group = new Group();

  constructor(
    private readonly hand: HandModel,
    cuff: RigidMesh,
  ) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(cuff.positions, 3));
    geometry.setIndex(new BufferAttribute(cuff.triangles, 1));
    geometry.computeVertexNormals();
    const mesh = new Mesh(geometry, new MeshStandardMaterial({ color: CLOTH, roughness: 0.95 }));
    mesh.castShadow = mesh.receiveShadow = true;
    this.group.add(mesh);
  }

  setVisible(visible: boolean): void {
    this.group.visible = visible;
  }

  /** Follows the palm: poses of all rigid bodies, seven numbers each. */
  update(rigids: Float32Array): void {
    const palm = this.hand.bones.findIndex((bone) => bone.parent === null);
    const at = 7 * (this.hand.bone_start + palm);
    this.group.position.fromArray(rigids, at);
    this.group.quaternion.fromArray(rigids, at + 3);
  }
}
