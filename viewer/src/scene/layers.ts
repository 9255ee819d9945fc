// What can be switched on and off in the picture.

export const LAYERS = [
  "skin",
  "flesh",
  "bones",
  "tracked",
  "skinning",
  "contacts",
  "forces",
  "pressure",
  "weights",
  "wireframe",
  "objects",
  "shadows",
  "ground",
] as const;

export type LayerName = (typeof LAYERS)[number];

/** For people: what each layer shows. */
export const LAYER_LABELS: Readonly<Record<LayerName, string>> = {
  skin: "Skin",
  flesh: "Flesh tetrahedra",
  bones: "Bones and joints",
  tracked: "Tracked hand",
  skinning: "Skinning without flesh",
  contacts: "Contact points",
  forces: "Contact forces",
  pressure: "Pressure on the skin",
  weights: "Skinning weights",
  wireframe: "Wireframe of objects",
  objects: "Objects",
  shadows: "Shadows",
  ground: "Ground",
};

/** These colour the skin: one at a time. */
export const ON_SKIN: readonly LayerName[] = ["pressure", "weights"];

export const LAYERS_AT_FIRST: ReadonlySet<LayerName> = new Set<LayerName>([
  "skin",
  "objects",
  "shadows",
  "ground",
]);

/** Camera presets, in the order of the keys 1 to 6. */
export const VIEWS = ["scene", "front", "side", "top", "below", "close"] as const;
export type ViewName = (typeof VIEWS)[number];
