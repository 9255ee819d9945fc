// The paper's figures, as views of our own scenes.

export interface Figure {
  /** As the paper numbers it. */
  readonly name: string;
  readonly file: string;
  readonly scene: string;
  /** After `#scene=…&`. */
  readonly view: string;
  readonly text: string;
}

const PLAIN = "layers=skin,objects,shadows,ground";
/** The open hand of the free motion, whole. */
const WHOLE = "&camera=0.22,0.21,0.70,0,0.2,0,25";

export const FIGURES: readonly Figure[] = [
  {
    name: "Figure 1, left",
    file: "fig-1-left.jpg",
    scene: "free-motion",
    view: `t=3.3&${PLAIN}`,
    text: "The deformable hand follows a motion in free air.",
  },
  {
    name: "Figure 1, centre",
    file: "fig-1-centre.jpg",
    scene: "bread-grasp",
    view: `t=3.1&${PLAIN}`,
    text: "It holds a loaf of bread; friction alone carries it.",
  },
  {
    name: "Figure 2, left",
    file: "fig-2-left.jpg",
    scene: "free-motion",
    view: `t=0.8&layers=bones,shadows,ground${WHOLE}`,
    text: "The skeleton of 16 bones; hinge joints are blue, universal joints red.",
  },
  {
    name: "Figure 2, middle",
    file: "fig-2-middle.jpg",
    scene: "free-motion",
    view: `t=0.8&${PLAIN}${WHOLE}`,
    text: "The surface that is drawn, 23 640 triangles.",
  },
  {
    name: "Figure 2, right",
    file: "fig-2-right.jpg",
    scene: "free-motion",
    view: `t=0.8&layers=flesh,shadows,ground${WHOLE}`,
    text: "The tetrahedra that carry it, each drawn a little smaller than it is.",
  },
  {
    name: "Figure 3",
    file: "fig-3.jpg",
    scene: "free-motion",
    view: `t=0.8&layers=skin,weights,shadows,ground&weights=index-proximal,ring-intermediate,thumb-distal${WHOLE}`,
    text: "Skinning weights of three bones: blue is 0, red is 1.",
  },
  {
    name: "Figure 4",
    file: "fig-4.jpg",
    scene: "glove-versus-hand",
    view: "t=3.2&layers=skin,tracked,objects,shadows,ground",
    text: "Contact holds the simulated hand back; the tracked one, in yellow and pale beside it, sinks into the table.",
  },
  {
    name: "Figure 5",
    file: "fig-5.jpg",
    scene: "table-press",
    view: `t=3.8&${PLAIN}`,
    text: "Pressed on a table, the fingertips flatten and the skeleton gives way.",
  },
  {
    name: "Figure 6",
    file: "fig-6.jpg",
    scene: "skinning-comparison",
    view: `t=2.6&${PLAIN}`,
    text: "The same skeleton with flesh (right) and by linear blend skinning alone (left, grey).",
  },
  {
    name: "Figure 7",
    file: "fig-7.jpg",
    scene: "car-grasp",
    view: `t=3.1&${PLAIN}`,
    text: "A rigid toy car, lifted.",
  },
  {
    name: "Figure 8",
    file: "fig-8.jpg",
    scene: "bread-squeeze",
    view: `t=2.8&${PLAIN}`,
    text: "Both give way: the loaf is squeezed between soft fingers.",
  },
];

/** What follows the server's address. */
export function address(figure: Figure): string {
  return `#scene=${figure.scene}&${figure.view}`;
}

/** docs/gallery.md. */
export function gallery(): string {
  const parts = FIGURES.map(
    ({ name, file, scene, text, ...rest }) => `## ${name}

![${text}](images/gallery/${file})

${text}

\`\`\`sh
cargo run --release -- serve ${scene}
\`\`\`

then open \`http://127.0.0.1:8014/${address({ name, file, scene, text, ...rest })}\`.
To take the picture: \`npm --prefix viewer run gallery -- -t "${name}"\`
`,
  );
  return `# The paper's figures

The figures of Garre, Hernández, Gracia and Otaduy (2011) as our own scenes show them: each picture is
taken from the live page, with the simulation running behind it, stopped at a moment. Figure 1, right,
shows a force-feedback glove and is missing here. All pictures, and this page, are made by

\`\`\`sh
cargo build --release && npm --prefix viewer ci && npm --prefix viewer run gallery
\`\`\`

${parts.join("\n")}`;
}
