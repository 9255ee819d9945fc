// One deformable body: its skin or crust, and the tetrahedra inside.

import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  Group,
  LineSegments,
  Mesh,
  MeshStandardMaterial,
  ReplaceStencilOp,
  Vector3,
  type IUniform,
  type Texture,
} from "three";
import type { HandModel, SoftModel, Surface } from "../protocol/types";
import { Deformation } from "./deformation";
import {
  breadMaterial,
  depthOnly,
  embeddedDepthMaterial,
  embeddedLineMaterial,
  plainEmbeddedMaterial,
  pressureMaterial,
  skinMaterial,
  type Shared,
} from "./materials";
import { skinSites } from "./skin-sites";
import { restPositions, vertexNormals } from "./surface";

const SKIN = new Color(0.865, 0.685, 0.59).convertSRGBToLinear();
const BREAD = new Color(0.843, 0.604, 0.306).convertSRGBToLinear();
const RUBBER = new Color(0.25, 0.5, 0.62).convertSRGBToLinear();
const EDGE = new Color(0x8c1f2d);
const EDGE_CRUST = new Color(0x5a3a12);
const WIRE = new Color(0xd7e3ee);
const FLESH = new Color(0.78, 0.33, 0.3).convertSRGBToLinear();

/** What hands leave in the stencil buffer where they are seen. */
export const HAND_STENCIL = 1;

export class SoftView {
  readonly group = new Group();
  readonly deformation: Deformation;
  readonly nodes: IUniform<Texture>;
  readonly geometry: BufferGeometry;
  readonly rest: Float32Array;
  /** Pressure per vertex of the surface, Pa. */
  readonly pressure: BufferAttribute;
  /** Sum of the chosen bones' skinning weights per vertex of the surface. */
  readonly boneWeight: BufferAttribute;
  private readonly skin: Mesh;
  private readonly depth: Mesh;
  /** The loaded skin of both sides; made when the pressure first shows. */
  private glow: Mesh | null = null;
  private flesh: Mesh | null = null;
  private cells: LineSegments | null = null;
  private wire: LineSegments | null = null;
  private readonly material: MeshStandardMaterial;

  constructor(
    readonly model: SoftModel,
    readonly hand: HandModel | null,
    private readonly shared: Shared,
    private readonly clip: IUniform,
  ) {
    this.deformation = new Deformation(model.nodes, model.tets);
    this.nodes = { value: this.deformation.texture };
    this.rest = restPositions(model.render, model.nodes, model.tets);
    const normals = vertexNormals(this.rest, model.render.triangles);
    this.geometry = embeddedGeometry(model.render, model.tets, this.rest, normals);
    this.pressure = new BufferAttribute(new Float32Array(this.rest.length / 3), 1);
    this.geometry.setAttribute("pressure", this.pressure);
    this.boneWeight = new BufferAttribute(new Float32Array(this.rest.length / 3), 1);
    this.geometry.setAttribute("boneWeight", this.boneWeight);
    this.material = this.makeMaterial(normals);
    this.skin = drawn(this.geometry, this.material);
    this.skin.castShadow = this.skin.receiveShadow = true;
    this.skin.customDepthMaterial = embeddedDepthMaterial(this.nodes);
    this.depth = drawn(this.geometry, depthOnly(embeddedDepthMaterial(this.nodes)));
    this.depth.renderOrder = 1;
    this.skin.renderOrder = 2;
    this.material.stencilWrite = true;
    this.material.stencilRef = model.hand === null ? 0 : HAND_STENCIL;
    this.material.stencilZPass = ReplaceStencilOp;
    this.depth.visible = false;
    this.group.add(this.skin, this.depth);
  }

  private makeMaterial(normals: Float32Array): MeshStandardMaterial {
    const { model, hand, shared, nodes } = this;
    const own = model.colour === null ? null : new Color(...model.colour).convertSRGBToLinear();
    switch (model.look) {
      case "skin": {
        if (hand !== null && model.skin !== null) {
          const { site, curve } = skinSites(model, model.skin, hand, this.rest, normals);
          this.geometry.setAttribute("site", new BufferAttribute(site, 4));
          this.geometry.setAttribute("curve", new BufferAttribute(curve, 1));
          return skinMaterial(own ?? SKIN, nodes, shared);
        }
        return plainEmbeddedMaterial(new MeshStandardMaterial({ color: own ?? SKIN }), nodes, shared);
      }
      case "bread":
        return breadMaterial(own ?? BREAD, model.render.colours !== null, nodes, shared, longest(this.rest));
      case "rubber":
        return plainEmbeddedMaterial(
          new MeshStandardMaterial({ color: own ?? RUBBER, roughness: 0.45 }),
          nodes,
          shared,
        );
    }
  }

  /** `through`: the surface lets what is inside show. Flesh shows as solid cells, or as their edges
   * around a surface that shows too. */
  setVisible(skin: boolean, through: boolean, flesh: boolean, wire: boolean): void {
    this.skin.visible = skin;
    this.skin.castShadow = skin;
    this.depth.visible = skin && through;
    if (this.material.transparent !== through) {
      this.material.transparent = through;
      this.material.opacity = through ? 0.45 : 1;
      this.material.needsUpdate = true;
    }
    const solid = flesh && !skin;
    const edges = flesh && skin;
    if (solid && this.flesh === null) this.makeFlesh();
    if (this.flesh !== null) this.flesh.visible = solid;
    if (edges && this.cells === null) this.makeEdges();
    if (this.cells !== null) this.cells.visible = edges;
    if (wire && this.wire === null) this.makeWire();
    if (this.wire !== null) this.wire.visible = wire;
  }

  /** The edges of the surface that is drawn. */
  private makeWire(): void {
    const geometry = new BufferGeometry();
    for (const name of ["position", "corner", "weight"]) {
      geometry.setAttribute(name, this.geometry.getAttribute(name));
    }
    geometry.setIndex(triangleEdges(this.model.render.triangles));
    this.wire = new LineSegments(geometry, embeddedLineMaterial(WIRE, this.nodes));
    this.wire.frustumCulled = false;
    this.wire.renderOrder = 5;
    this.group.add(this.wire);
  }

  /** The pressure on the far side shows through the near one, which lets light through by then. */
  setGlow(on: boolean): void {
    if (on && this.glow === null) {
      this.glow = drawn(this.geometry, pressureMaterial(this.nodes, this.shared));
      // Before the skin's depth, which would hide the far side.
      this.glow.renderOrder = 0.5;
      this.group.add(this.glow);
    }
    if (this.glow !== null) this.glow.visible = on;
  }

  private makeEdges(): void {
    const geometry = edgeGeometry(this.model);
    this.cells = new LineSegments(
      geometry,
      embeddedLineMaterial(this.hand === null ? EDGE_CRUST : EDGE, this.nodes),
    );
    this.cells.frustumCulled = false;
    this.cells.renderOrder = 5;
    this.group.add(this.cells);
  }

  private makeFlesh(): void {
    const material = new MeshStandardMaterial({
      color: 0xffffff,
      vertexColors: true,
      flatShading: true,
      roughness: 0.75,
    });
    const tint = this.hand !== null ? FLESH : BREAD;
    this.flesh = drawn(
      cellGeometry(this.model, tint),
      plainEmbeddedMaterial(material, this.nodes, this.shared, this.clip),
    );
    this.flesh.castShadow = this.flesh.receiveShadow = true;
    this.flesh.customDepthMaterial = embeddedDepthMaterial(this.nodes, 0, this.clip);
    this.group.add(this.flesh);
  }

  update(nodes: Float32Array): void {
    this.deformation.update(nodes, this.model.node_start);
  }

  dispose(): void {
    this.deformation.dispose();
    this.geometry.dispose();
    this.material.dispose();
    this.flesh?.geometry.dispose();
    this.cells?.geometry.dispose();
    this.wire?.geometry.dispose();
  }
}

/** The axis along which a body is longest. */
function longest(rest: Float32Array): Vector3 {
  const size = new Box3().setFromArray(Array.from(rest)).getSize(new Vector3());
  if (size.x >= size.y && size.x >= size.z) return new Vector3(1, 0, 0);
  return size.y >= size.z ? new Vector3(0, 1, 0) : new Vector3(0, 0, 1);
}

/** A mesh whose place only its shader knows. */
export function drawn(geometry: BufferGeometry, material: ConstructorParameters<typeof Mesh>[1]): Mesh {
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}

export function embeddedGeometry(
  surface: Surface,
  tets: Uint32Array,
  rest: Float32Array,
  normals: Float32Array,
): BufferGeometry {
  const geometry = new BufferGeometry();
  const corners = new Float32Array(4 * surface.tets.length);
  for (let v = 0; v < surface.tets.length; v++) {
    for (let k = 0; k < 4; k++) corners[4 * v + k] = tets[4 * surface.tets[v] + k];
  }
  geometry.setAttribute("position", new BufferAttribute(rest, 3));
  geometry.setAttribute("normal", new BufferAttribute(normals, 3));
  geometry.setAttribute("corner", new BufferAttribute(corners, 4));
  geometry.setAttribute("weight", new BufferAttribute(surface.weights, 4));
  geometry.setIndex(new BufferAttribute(surface.triangles, 1));
  if (surface.colours !== null) geometry.setAttribute("color", linearColours(surface.colours));
  geometry.computeBoundingSphere();
  return geometry;
}

/** sRGB bytes as linear light, which is what shaders multiply. */
export function linearColours(bytes: Uint8Array): BufferAttribute {
  const out = new Float32Array((bytes.length / 4) * 3);
  const colour = new Color();
  for (let v = 0; v < bytes.length / 4; v++) {
    colour.setRGB(bytes[4 * v] / 255, bytes[4 * v + 1] / 255, bytes[4 * v + 2] / 255);
    colour.convertSRGBToLinear().toArray(out, 3 * v);
  }
  return new BufferAttribute(out, 3);
}

/** Each edge between two nodes once. */
function edgeGeometry(soft: SoftModel): BufferGeometry {
  const count = soft.nodes.length / 3;
  const [corner, weight] = [new Float32Array(4 * count), new Float32Array(4 * count)];
  for (let n = 0; n < count; n++) {
    corner.fill(n, 4 * n, 4 * n + 4);
    weight[4 * n] = 1;
  }
  const edges = new Set<number>();
  for (let t = 0; t < soft.tets.length; t += 4) {
    for (let a = 0; a < 4; a++) {
      for (let b = a + 1; b < 4; b++) {
        const [low, high] = [soft.tets[t + a], soft.tets[t + b]].sort((x, y) => x - y);
        edges.add(low * count + high);
      }
    }
  }
  const index = [...edges].flatMap((edge) => [Math.floor(edge / count), edge % count]);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(soft.nodes, 3));
  geometry.setAttribute("corner", new BufferAttribute(corner, 4));
  geometry.setAttribute("weight", new BufferAttribute(weight, 4));
  geometry.setIndex(index);
  return geometry;
}

/** Both ends of each edge, once. */
function triangleEdges(triangles: Uint32Array): number[] {
  const seen = new Set<string>();
  const out: number[] = [];
  for (let t = 0; t < triangles.length; t += 3) {
    for (let k = 0; k < 3; k++) {
      const [low, high] = [triangles[t + k], triangles[t + ((k + 1) % 3)]].sort((a, b) => a - b);
      const name = `${low},${high}`;
      if (!seen.has(name)) out.push(low, high);
      seen.add(name);
    }
  }
  return out;
}

const SHRINK = 0.14;
const FACES = [1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1];

/** Every tetrahedron, a little shrunk towards its middle; again an embedded surface. */
function cellGeometry(soft: SoftModel, tint: Color): BufferGeometry {
  const count = soft.tets.length / 4;
  const [corner, weight] = [new Float32Array(48 * count), new Float32Array(48 * count)];
  const [rest, cell, colour] = [0, 1, 2].map(() => new Float32Array(36 * count));
  const shade = new Color();
  for (let t = 0; t < count; t++) {
    const centre = [0, 0, 0];
    for (let k = 0; k < 4; k++) {
      for (let c = 0; c < 3; c++) centre[c] += soft.nodes[3 * soft.tets[4 * t + k] + c] / 4;
    }
    const hash = Math.abs(Math.sin(t * 12.9898) * 43758.5453) % 1;
    shade.copy(tint).offsetHSL((hash - 0.5) * 0.03, 0, (hash - 0.5) * 0.1);
    for (let f = 0; f < 12; f++) {
      const v = 12 * t + f;
      for (let k = 0; k < 4; k++) {
        corner[4 * v + k] = soft.tets[4 * t + k];
        weight[4 * v + k] = SHRINK / 4 + (FACES[f] === k ? 1 - SHRINK : 0);
      }
      rest.set(centre, 3 * v);
      cell.set(centre, 3 * v);
      shade.toArray(colour, 3 * v);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(rest, 3));
  geometry.setAttribute("corner", new BufferAttribute(corner, 4));
  geometry.setAttribute("weight", new BufferAttribute(weight, 4));
  geometry.setAttribute("cell", new BufferAttribute(cell, 3));
  geometry.setAttribute("color", new BufferAttribute(colour, 3));
  return geometry;
}
