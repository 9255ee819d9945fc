// When and how each built-in scene has its small picture taken.

export interface MomentOfScene {
  readonly scene: string;
  /** Simulated time, s: when what the title says is seen. */
  readonly t: number;
  /** After `#`: another camera or other layers than the scene's own. */
  readonly view?: string;
}

export const MOMENTS: readonly MomentOfScene[] = [
  { scene: "ball-grip", t: 3.2 },
  { scene: "body", t: 0.2 },
  { scene: "bread-grasp", t: 3.1 },
  { scene: "bread-squeeze", t: 2.8 },
  { scene: "car-grasp", t: 3.1 },
  { scene: "card", t: 3.0 },
  { scene: "egg", t: 3.0 },
  { scene: "falling-box", t: 0.2 },
  { scene: "finger-pendulum", t: 0.05, view: "layers=bones,objects,shadows&camera=close" },
  { scene: "fist", t: 2.6 },
  { scene: "forearm", t: 1.8 },
  { scene: "free-motion", t: 3.3 },
  { scene: "glove-versus-hand", t: 3.2, view: "layers=skin,tracked,objects,shadows,ground" },
  { scene: "gripper", t: 2.8 },
  { scene: "pen", t: 3.0 },
  { scene: "pinch", t: 1.6 },
  { scene: "skinning-comparison", t: 2.6 },
  { scene: "soft-cube", t: 0.3 },
  { scene: "table-press", t: 2.0 },
  { scene: "two-hands", t: 3.0 },
];
