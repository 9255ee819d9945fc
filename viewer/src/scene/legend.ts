// What colours and arrows mean, with numbers, in a corner of the page.

import "./legend.css";
import { CONTACT_COLOURS } from "./contact-view";
import { JOINT_COLOURS } from "./rigid-view";
import { cssGradient, STOPS, WEIGHT_STOPS } from "./colour-map";

/** What the picture shows that needs telling; null and false: not shown. */
export interface Shown {
  /** End of the pressure scale, Pa. */
  readonly pressure: number | null;
  /** Of the longest arrow, N. */
  readonly force: number | null;
  /** Whose skinning weights show. */
  readonly bones: readonly string[] | null;
  readonly joints: boolean;
  readonly contacts: boolean;
}

export class Legend {
  readonly element = document.createElement("div");
  private readonly pressure = document.createElement("div");
  private readonly forces = document.createElement("div");
  private readonly most = document.createElement("span");
  private readonly arrow = document.createElement("span");
  private readonly middle = document.createElement("span");
  private readonly weights = document.createElement("div");
  private readonly joints = document.createElement("div");
  private readonly contacts = document.createElement("div");
  private readonly whose = document.createElement("span");

  constructor() {
    this.element.className = "scales";
    this.element.hidden = true;
    this.pressure.className = "scale-pressure";
    this.pressure.append("Pressure on the skin, kPa", ...scale(cssGradient(STOPS), "0", this.middle, this.most));
    this.pressure.append("Clear skin bears no load.");
    this.weights.className = "scale-weights";
    this.weights.append("Skinning weight ", this.whose, ...scale(cssGradient(WEIGHT_STOPS), "0", "0.5", "1"));
    this.forces.className = "scale-forces";
    this.forces.append(
      swatch(CONTACT_COLOURS.normal, "normal force"),
      swatch(CONTACT_COLOURS.shear, "friction"),
      this.arrow,
    );
    this.contacts.className = "scale-contacts";
    this.contacts.append(
      swatch(CONTACT_COLOURS.sticking, "contact that sticks"),
      swatch(CONTACT_COLOURS.sliding, "that slides"),
    );
    this.joints.className = "scale-joints";
    this.joints.append(
      swatch(JOINT_COLOURS.hinge, "hinge joint"),
      swatch(JOINT_COLOURS.universal, "universal joint"),
    );
    this.element.append(this.pressure, this.weights, this.contacts, this.forces, this.joints);
  }

  show({ pressure, force, bones, joints, contacts }: Shown): void {
    this.element.hidden = pressure === null && force === null && bones === null && !joints && !contacts;
    this.contacts.hidden = !contacts;
    this.joints.hidden = !joints;
    this.weights.hidden = bones === null;
    if (bones !== null) write(this.whose, bones.length === 0 ? "(no bone chosen)" : `of ${bones.map((bone) => bone.replace("-", "\u2011")).join(" + ")}`);
    this.pressure.hidden = pressure === null;
    this.forces.hidden = force === null;
    if (pressure !== null) {
      write(this.middle, `${Number((pressure / 2000).toPrecision(3))}`);
      write(this.most, `${Number((pressure / 1000).toPrecision(3))}`);
    }
    if (force !== null) write(this.arrow, `longest arrow ${Number(force.toPrecision(3))} N`);
  }
}

function write(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** A bar of colours with numbers at its beginning, middle and end. */
function scale(gradient: string, ...ends: readonly (string | HTMLElement)[]): HTMLElement[] {
  const bar = document.createElement("div");
  bar.className = "scale-bar";
  bar.style.background = gradient;
  const numbers = document.createElement("div");
  numbers.className = "scale-numbers";
  for (const end of ends) {
    const number = typeof end === "string" ? document.createElement("span") : end;
    if (typeof end === "string") number.textContent = end;
    numbers.append(number);
  }
  return [bar, numbers];
}

function swatch(colour: string, text: string): HTMLElement {
  const item = document.createElement("span");
  item.className = "scale-swatch";
  const dot = document.createElement("i");
  dot.style.background = colour;
  item.append(dot, text);
  return item;
}
