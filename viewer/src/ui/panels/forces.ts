// Force, contact area and mean pressure of each finger: a hand with numbers, a table, a rolling plot.

import { Chart } from "../chart";
import type { Desk, Panel } from "../desk";
import { h, setText } from "../dom";
import { fixed, significant } from "../format";
import { HandDiagram } from "../hand-diagram";
import { ICONS } from "../icons";
import {
  COLUMNS,
  DIGIT_COLOURS,
  DIGIT_LABELS,
  HANDS_MOST,
  QUANTITIES,
  sample,
  wholeHand,
  type Quantity,
} from "../quantities";
import { RollingSeries } from "../series";
import { select } from "../widgets";
import { PER_DIGIT, PER_HAND } from "../../protocol/types";

/** Of the plot, s, and samples of it: 5 s at 400 steps per second. */
const SPAN = 5;
const SAMPLES = 2000;
/** Redrawn at most this often, ms. */
const REDRAW = 60;

export function forcesPanel(desk: Desk): Panel {
  const { feed } = desk.app;
  const series = new RollingSeries(COLUMNS, SAMPLES, SPAN);
  const row = new Float32Array(COLUMNS);
  const chart = new Chart(series);
  const diagram = new HandDiagram();
  let quantity: Quantity = QUANTITIES[0];
  let hand = 0;
  let open = false;
  let drawnAt = 0;

  const unit = h("span", { class: "unit" });
  const legend = h("div", { class: "legend" });
  const restart = () => {
    const curves = quantity.curves(hand);
    chart.show(quantity, curves);
    setText(unit, `${quantity.label}, ${quantity.unit}, last ${SPAN} s`);
    legend.replaceChildren(
      ...curves.map((curve) => {
        const mark = h("i", { class: curve.dashed === true ? "dashed" : "" });
        mark.style.color = curve.colour;
        return h("span", {}, mark, curve.label);
      }),
    );
  };
  const what = select(
    "Plot",
    QUANTITIES.map((q) => [q.id, q.label] as const),
    (id) => {
      quantity = QUANTITIES.find((q) => q.id === id) ?? QUANTITIES[0];
      restart();
    },
  );
  const which = select("Hand", [], (value) => {
    hand = Number(value);
    diagram.build(feed.model?.hands[hand]?.side ?? "right");
    restart();
    write();
  });

  which.element.hidden = true;

  const cells = DIGIT_LABELS.map((label, d) => {
    const values = [h("td"), h("td"), h("td"), h("td")];
    const dot = h("i", { class: "dot" });
    dot.style.background = DIGIT_COLOURS[d];
    return { values, row: h("tr", {}, h("th", { scope: "row" }, dot, label), ...values) };
  });
  const total = [h("td"), h("td"), h("td"), h("td")];
  const head = (text: string, of: string) => h("th", { scope: "col" }, text, h("small", {}, ` ${of}`));
  const table = h(
    "table",
    { class: "numbers" },
    h(
      "thead",
      {},
      h(
        "tr",
        {},
        h("td"),
        head("Normal", "N"),
        head("Shear", "N"),
        head("Area", "mm²"),
        head("Pressure", "kPa"),
      ),
    ),
    h("tbody", {}, ...cells.map((cell) => cell.row)),
    h("tfoot", {}, h("tr", {}, h("th", { scope: "row" }, "All"), ...total)),
  );
  const facts = h("dl", { class: "facts" });

  const put = (row: readonly HTMLElement[], [normal, shear, area, pressure]: Iterable<number>) => {
    const texts = [fixed(normal, 2), fixed(shear, 2), fixed(1e6 * area, 0), fixed(1e-3 * pressure, 1)];
    [normal, shear, area, pressure].forEach((value, k) => {
      setText(row[k], texts[k]);
      row[k].dataset["zero"] = String(value === 0);
    });
  };
  const write = () => {
    const { snapshot } = feed;
    if (snapshot === null) return;
    const fingers = snapshot.fingers.subarray(PER_HAND * hand, PER_HAND * (hand + 1));
    diagram.show(fingers);
    cells.forEach(({ values }, d) => put(values, fingers.subarray(PER_DIGIT * d, PER_DIGIT * (d + 1))));
    put(total, wholeHand(fingers));
    const rows: [string, string][] = [
      ["Step", `${fixed(snapshot.stepCost, 1)} of ${fixed(snapshot.stepBudget, 1)} ms`],
      ["Contacts", String(snapshot.contacts.count)],
      ["Solver sweeps", String(snapshot.sweeps)],
      ["Deepest penetration", `${significant(1e3 * snapshot.penetration, 2)} mm`],
      ["Largest joint gap", `${significant(1e3 * snapshot.jointGap, 2)} mm`],
    ];
    facts.replaceChildren(...rows.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
  };

  diagram.show(new Float32Array(PER_HAND));
  feed.on("model", (model) => {
    series.clear();
    hand = Math.min(hand, Math.max(0, model.hands.length - 1));
    const hands = model.hands.slice(0, HANDS_MOST);
    which.input.replaceChildren(
      ...hands.map((item, i) => h("option", { value: i }, `${item.name} (${item.side})`)),
    );
    which.input.value = String(hand);
    which.element.hidden = hands.length < 2;
    diagram.element.toggleAttribute("hidden", hands.length === 0);
    table.hidden = hands.length === 0;
    diagram.build(hands[hand]?.side ?? "right");
    if (open) restart();
  });
  feed.on("snapshot", (snapshot) => {
    sample(snapshot, row);
    series.push(snapshot.time, row);
    const now = performance.now();
    if (!open || now - drawnAt < REDRAW) return;
    drawnAt = now;
    chart.draw();
    write();
  });

  return {
    id: "forces",
    title: "Forces",
    icon: ICONS.forces,
    body: h(
      "div",
      {},
      which.element,
      diagram.element,
      what.element,
      chart.element,
      h("p", { class: "caption" }, unit),
      legend,
      table,
      facts,
    ),
    shown(now) {
      open = now;
      if (now) {
        restart();
        write();
      }
    },
  };
}
