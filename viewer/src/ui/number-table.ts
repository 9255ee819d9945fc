// Normal and shear force, contact area and mean pressure, one row per digit or body.

import { PER_DIGIT } from "../protocol/types";
import { h, setText } from "./dom";
import { fixed } from "./format";
import type { Part } from "./quantities";

/** A row's texts, from normal force N, shear force N, area m² and pressure Pa. */
export function rowTexts([normal, shear, area, pressure]: Iterable<number>): string[] {
  return [fixed(normal, 2), fixed(shear, 2), fixed(1e6 * area, 0), fixed(1e-3 * pressure, 1)];
}

const COLUMNS: readonly (readonly [string, string])[] = [
  ["Normal", "N"],
  ["Shear", "N"],
  ["Area", "mm²"],
  ["Pressure", "kPa"],
];

export class NumberTable {
  private readonly body = h("tbody");
  private readonly total = cells();
  private readonly foot = h("tfoot", {}, h("tr", {}, h("th", { scope: "row" }, "All"), ...this.total));
  private rows: HTMLElement[][] = [];
  readonly element = h("table", { class: "numbers", hidden: true }, h("thead", {}, h("tr", {}, h("td"), ...heads())), this.body, this.foot);

  /** One row for each part; a row for all of them where that means something. */
  build(parts: readonly Part[], total: boolean): void {
    this.rows = parts.map(cells);
    this.body.replaceChildren(
      ...parts.map(({ label, colour }, p) => {
        const dot = h("i", { class: "dot" });
        dot.style.background = colour;
        return h("tr", {}, h("th", { scope: "row", title: label }, dot, label), ...this.rows[p]);
      }),
    );
    this.foot.hidden = !total;
    this.element.hidden = parts.length === 0;
  }

  /** Four numbers for each part, and the total's. */
  write(numbers: Float32Array, total: readonly number[] | null): void {
    this.rows.forEach((row, p) => put(row, numbers.subarray(PER_DIGIT * p, PER_DIGIT * (p + 1))));
    if (total !== null) put(this.total, total);
  }
}

function cells(): HTMLElement[] {
  return COLUMNS.map(() => h("td"));
}

function heads(): HTMLElement[] {
  return COLUMNS.map(([text, unit]) => h("th", { scope: "col" }, text, h("small", {}, ` ${unit}`)));
}

function put(row: readonly HTMLElement[], numbers: Iterable<number>): void {
  const values = [...numbers];
  rowTexts(values).forEach((text, k) => {
    setText(row[k], text);
    row[k].dataset["zero"] = String(values[k] === 0);
  });
}
