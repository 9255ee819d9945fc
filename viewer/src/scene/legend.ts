// What colours and arrows mean, with numbers, in a corner of the page.

import "./legend.css";
import { CONTACT_COLOURS } from "./contact-view";
import { cssGradient } from "./colour-map";

export class Legend {
  readonly element = document.createElement("div");
  private readonly pressure = document.createElement("div");
  private readonly forces = document.createElement("div");
  private readonly most = document.createElement("span");
  private readonly arrow = document.createElement("span");
  private readonly middle = document.createElement("span");

  constructor() {
    this.element.className = "scales";
    this.element.hidden = true;
    this.pressure.className = "scale-pressure";
    const bar = document.createElement("div");
    bar.className = "scale-bar";
    bar.style.background = cssGradient();
    const numbers = document.createElement("div");
    numbers.className = "scale-numbers";
    const zero = document.createElement("span");
    zero.textContent = "0";
    numbers.append(zero, this.middle, this.most);
    this.pressure.append("Pressure", bar, numbers);
    this.forces.className = "scale-forces";
    this.forces.append(
      swatch(CONTACT_COLOURS.normal, "normal force"),
      swatch(CONTACT_COLOURS.shear, "friction"),
      this.arrow,
    );
    this.element.append(this.pressure, this.forces);
  }

  /** `pressure` in Pa and `force` in N at the ends of their scales; null hides one. */
  show(pressure: number | null, force: number | null): void {
    this.element.hidden = pressure === null && force === null;
    this.pressure.hidden = pressure === null;
    this.forces.hidden = force === null;
    if (pressure !== null) {
      write(this.middle, `${Number((pressure / 2000).toPrecision(3))}`);
      write(this.most, `${Number((pressure / 1000).toPrecision(3))} kPa`);
    }
    if (force !== null) write(this.arrow, `longest arrow ${Number(force.toPrecision(3))} N`);
  }
}

function write(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

function swatch(colour: string, text: string): HTMLElement {
  const item = document.createElement("span");
  item.className = "scale-swatch";
  const dot = document.createElement("i");
  dot.style.background = colour;
  item.append(dot, text);
  return item;
}
