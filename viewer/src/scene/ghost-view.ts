// A hand's skin without its flesh: nodes at their skinning targets, either of the tracked pose (the
// paper's Fig. 4) or of the simulated bones (Fig. 6).

import {
  Color,
  GreaterDepth,
  Group,
  MeshStandardMaterial,
  NotEqualStencilFunc,
  type IUniform,
  type Mesh,
  type Texture,
} from "three";
import type { HandModel, Skin } from "../protocol/types";
import { Deformation } from "./deformation";
import { depthOnly, embeddedDepthMaterial, plainEmbeddedMaterial, type Shared } from "./materials";
import { completeSkin, restPoses, skinNodes } from "./skinning";
import { drawn, HAND_STENCIL, type SoftView } from "./soft-view";

export type GhostOf = "tracked" | "skinning";

/** Drawn this far inside its surface, m: where it agrees with the flesh it does not show. */
const INSET = 0.0008;

const COLOUR = { tracked: new Color(0xffc81e), skinning: new Color(0x6fa8ff) };

export class GhostView {
  readonly group = new Group();
  private readonly deformation: Deformation;
  private readonly nodes: Float32Array;
  private readonly skin: Skin;
  private readonly solid: MeshStandardMaterial;
  private readonly depth: Mesh;
  private on = false;

  constructor(
    readonly of: GhostOf,
    body: SoftView,
    skin: Skin,
    private readonly hand: HandModel,
    shared: Shared,
  ) {
    const soft = body.model;
    this.skin = completeSkin(soft, skin, hand, restPoses(soft, skin, hand));
    this.nodes = new Float32Array(soft.nodes.length);
    this.deformation = new Deformation(soft.nodes, soft.tets);
    const nodes: IUniform<Texture> = { value: this.deformation.texture };
    this.solid = plainEmbeddedMaterial(
      new MeshStandardMaterial({
        color: COLOUR[of],
        roughness: 0.5,
        transparent: true,
        opacity: of === "tracked" ? 0.42 : 0.85,
        depthWrite: false,
      }),
      nodes,
      shared,
      null,
      INSET,
    );
    const mesh = drawn(body.geometry, this.solid);
    mesh.customDepthMaterial = embeddedDepthMaterial(nodes);
    mesh.renderOrder = 4;
    this.depth = drawn(body.geometry, depthOnly(embeddedDepthMaterial(nodes, INSET)));
    this.depth.renderOrder = 3;
    this.group.add(this.depth, mesh);
    if (of === "tracked") this.group.add(this.behind(body, nodes, shared));
    this.group.visible = false;
  }

  /** What lies inside a table or a loaf shows through it, faintly; through the hand it does not. */
  private behind(body: SoftView, nodes: IUniform<Texture>, shared: Shared): Mesh {
    const material = new MeshStandardMaterial({
      color: COLOUR[this.of],
      transparent: true,
      opacity: 0.26,
      depthWrite: false,
      depthFunc: GreaterDepth,
      stencilWrite: true,
      stencilRef: HAND_STENCIL,
      stencilFunc: NotEqualStencilFunc,
    });
    const mesh = drawn(body.geometry, plainEmbeddedMaterial(material, nodes, shared, null, INSET));
    mesh.renderOrder = 2;
    return mesh;
  }

  setVisible(on: boolean): void {
    this.on = on;
    this.group.visible = on;
  }

  update(rigids: Float32Array, targets: Float32Array): void {
    if (!this.on) return;
    const tracked = this.of === "tracked";
    const poses = tracked ? targets : rigids;
    const first = tracked ? this.hand.bone_start - this.hand.target_start : 0;
    const known = skinNodes(this.skin, poses, first, this.nodes);
    this.group.visible = known;
    if (known) this.deformation.update(this.nodes, 0);
  }

  dispose(): void {
    this.deformation.dispose();
    this.solid.dispose();
  }
}
