// What the visitor sets for recorded motion: which, how fast, once or again and again.

import { button, h } from "../ui/dom";
import { takeDrops } from "../ui/drops";

export interface MotionChoice {
  readonly id: string;
  readonly title: string;
}

interface Listeners {
  file(file: File): void;
  chosen(): void;
}

const FILE = "file";
const SPEEDS = [0.25, 0.5, 1, 2];

export class MotionControls {
  readonly element: HTMLElement;
  private readonly select: HTMLSelectElement;
  private readonly speeds: HTMLSelectElement;
  private readonly again: HTMLInputElement;

  constructor(choices: readonly MotionChoice[], listeners: Listeners) {
    this.select = h("select", { "aria-label": "Motion", onchange: () => listeners.chosen() });
    for (const { id, title } of choices) this.select.append(new Option(title, id));
    this.speeds = h("select", { "aria-label": "Speed of the motion" });
    for (const speed of SPEEDS) {
      this.speeds.append(new Option(`${speed}×`, String(speed), speed === 1, speed === 1));
    }
    this.again = h("input", { type: "checkbox", checked: true });
    const chooser = h("input", {
      type: "file",
      accept: ".jsonl,.json,.ndjson",
      hidden: true,
      onchange: () => {
        const file = chooser.files?.[0];
        if (file !== undefined) listeners.file(file);
        chooser.value = "";
      },
    });
    this.element = h(
      "div",
      { class: "motion-controls" },
      this.select,
      this.speeds,
      h("label", {}, this.again, " Repeat"),
      button("Open a recording…", () => chooser.click()),
      chooser,
    );
    takeDrops({ what: "a hand motion (.jsonl)", pattern: /\.(jsonl|ndjson|json)$/i, open: listeners.file });
  }

  /** Id of the motion chosen; `file` for the one loaded. */
  get chosen(): string {
    return this.select.value;
  }

  get speed(): number {
    return Number(this.speeds.value);
  }

  get loop(): boolean {
    return this.again.checked;
  }

  addFile(name: string): void {
    const old = [...this.select.options].find((option) => option.value === FILE);
    if (old !== undefined) old.text = name;
    else this.select.append(new Option(name, FILE));
    this.select.value = FILE;
  }
}
