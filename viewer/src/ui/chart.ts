// A rolling plot of a few curves over the last seconds.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { h } from "./dom";
import { significant } from "./format";
import type { Curve, Quantity } from "./quantities";
import type { RollingSeries } from "./series";

const HEIGHT = 170;

export class Chart {
  readonly element = h("div", { class: "chart" });
  private plot: uPlot | null = null;
  private quantity: Quantity | null = null;
  private curves: readonly Curve[] = [];

  constructor(private readonly series: RollingSeries) {
    new ResizeObserver(() => this.fit()).observe(this.element);
    // The axes' colours come from the style sheet.
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
  }

  show(quantity: Quantity, curves: readonly Curve[]): void {
    this.quantity = quantity;
    this.curves = curves;
    this.build();
  }

  draw(): void {
    const { plot, quantity } = this;
    if (plot === null || quantity === null) return;
    const data = this.series.read(this.curves.map((curve) => curve.column));
    if (quantity.factor !== 1) {
      for (const column of data.slice(1))
        for (let i = 0; i < column.length; i++) column[i] *= quantity.factor;
    }
    plot.setData(data, false);
    const last = this.series.last;
    const end = Number.isFinite(last) ? Math.max(last, this.series.span) : this.series.span;
    let top = quantity.least;
    let bottom = 0;
    for (const column of data.slice(1)) {
      for (const value of column) {
        if (value > top) top = value;
        if (value < bottom) bottom = value;
      }
    }
    plot.batch(() => {
      plot.setScale("x", { min: end - this.series.span, max: end });
      plot.setScale("y", { min: 1.05 * bottom, max: 1.08 * top });
    });
  }

  private fit(): void {
    const width = this.element.clientWidth;
    if (width > 0) this.plot?.setSize({ width, height: HEIGHT });
  }

  private build(): void {
    const { quantity } = this;
    if (quantity === null) return;
    this.plot?.destroy();
    const style = getComputedStyle(document.documentElement);
    const ink = style.getPropertyValue("--muted").trim();
    const grid = style.getPropertyValue("--line").trim();
    const axis = {
      stroke: ink,
      grid: { stroke: grid, width: 1 },
      ticks: { stroke: grid, width: 1, size: 4 },
      font: "11px system-ui, sans-serif",
    };
    this.plot = new uPlot(
      {
        width: Math.max(200, this.element.clientWidth),
        height: HEIGHT,
        legend: { show: false },
        cursor: { show: false },
        padding: [6, 6, 0, 0],
        scales: { x: { time: false, auto: false }, y: { auto: false } },
        axes: [
          { ...axis, size: 24, values: (_, ticks) => ticks.map((t) => `${significant(t, 4)} s`), space: 60 },
          { ...axis, size: 44, values: (_, ticks) => ticks.map((t) => significant(t)) },
        ],
        series: [
          {},
          ...this.curves.map((curve) => ({
            label: curve.label,
            stroke: curve.colour,
            width: 1.6,
            points: { show: false },
            ...(curve.dashed === true ? { dash: [5, 4] } : {}),
          })),
        ],
      },
      [[], ...this.curves.map(() => [])],
      this.element,
    );
    this.draw();
  }
}
