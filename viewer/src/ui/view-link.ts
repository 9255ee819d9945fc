// The address of a view: scene, layers, camera, moment and whether the panels show, after the "#".
// `#scene=bread-grasp&layers=skin,contacts&camera=close&t=2.1&ui=off`

import { LAYERS, VIEWS, type LayerName, type ViewName } from "../scene/layers";
import type { Vec3 } from "../protocol/types";

export interface CameraPlace {
  readonly position: Vec3;
  readonly target: Vec3;
  /** Vertical field of view, degrees; null: as it is. */
  readonly fov: number | null;
}

export interface ViewLink {
  readonly scene: string | null;
  /** Exactly these layers; null: as they are. */
  readonly layers: readonly LayerName[] | null;
  /** The bones whose skinning weights show; null: as they are. */
  readonly weights: readonly string[] | null;
  /** A named view or a place of its own, m. */
  readonly camera: ViewName | CameraPlace | null;
  /** Stop the simulation at this time, s. */
  readonly pauseAt: number | null;
  /** False: only the picture. */
  readonly ui: boolean;
}

const NUMBERS_MOST = 1000;
const NAMES_MOST = 100;

/** Reads an address. What makes no sense is left out: an old link still opens. */
export function parseLink(hash: string): ViewLink {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const scene = given.get("scene");
  return {
    scene: scene !== null && scene !== "" && scene.length <= 200 ? scene : null,
    layers: parseLayers(given.get("layers")),
    weights: parseNames(given.get("weights")),
    camera: parseCamera(given.get("camera")),
    pauseAt: parseTime(given.get("pause-at") ?? given.get("t")),
    ui: given.get("ui") !== "off",
  };
}

export function formatLink(link: ViewLink): string {
  const parts: string[] = [];
  if (link.scene !== null) parts.push(`scene=${encodeURIComponent(link.scene)}`);
  if (link.layers !== null) parts.push(`layers=${link.layers.join(",")}`);
  if (link.weights !== null) parts.push(`weights=${link.weights.map(encodeURIComponent).join(",")}`);
  if (link.camera !== null) parts.push(`camera=${formatCamera(link.camera)}`);
  if (link.pauseAt !== null) parts.push(`t=${Number(link.pauseAt.toFixed(4))}`);
  if (!link.ui) parts.push("ui=off");
  return parts.length === 0 ? "" : `#${parts.join("&")}`;
}

function parseLayers(text: string | null): LayerName[] | null {
  if (text === null) return null;
  const names = text.split(",");
  return LAYERS.filter((layer) => names.includes(layer));
}

function parseNames(text: string | null): string[] | null {
  const names = (text ?? "").split(",").filter((name) => name !== "" && name.length <= 100);
  return names.length === 0 || names.length > NAMES_MOST ? null : names;
}

function parseCamera(text: string | null): ViewName | CameraPlace | null {
  if (text === null) return null;
  const view = VIEWS.find((name) => name === text);
  if (view !== undefined) return view;
  const n = text.split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
  const six = n.length === 6 || n.length === 7;
  if (!six || !n.every((x) => Number.isFinite(x) && Math.abs(x) < NUMBERS_MOST)) return null;
  const [a, b, c, d, e, f, fov = null] = n;
  if (fov !== null && (fov < 1 || fov > 120)) return null;
  if (Math.hypot(a - d, b - e, c - f) < 1e-4) return null;
  return { position: [a, b, c], target: [d, e, f], fov };
}

function formatCamera(camera: ViewName | CameraPlace): string {
  if (typeof camera === "string") return camera;
  const fov = camera.fov === null ? [] : [camera.fov];
  return [...camera.position, ...camera.target, ...fov].map((x) => Number(x.toFixed(4))).join(",");
}

function parseTime(text: string | null): number | null {
  if (text === null || text.trim() === "") return null;
  const time = Number(text);
  return Number.isFinite(time) && time >= 0 && time < 1e6 ? time : null;
}
