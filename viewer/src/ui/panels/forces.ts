// Force, contact area and mean pressure of each finger: a hand with numbers, a table, a rolling plot. Where the scene has no
// hand, the same of each body.

import { BodyLoads } from "../body-loads";
import { Chart } from "../chart";
import type { Desk, Panel } from "../desk";
import { h, setText } from "../dom";
import { HandDiagram } from "../hand-diagram";
import { ICONS } from "../icons";
import { NumberTable } from "../number-table";
import {
  COLUMNS,
  DIGIT_PARTS,
  HANDS_MOST,
  QUANTITIES,
  bodyParts,
  sample,
  wholeHand,
  type Part,
  type Quantity,
} from "../quantities";
import { RollingSeries } from "../series";
import { STEP_FACTS } from "../step-facts";
import { select } from "../widgets";
import { PER_HAND, type SceneModel } from "../../protocol/types";

/** Of the plot, s, and samples of it: 5 s at 400 steps per second. */
const SPAN = 5;
const SAMPLES = 2000;
/** Redrawn at most this often, ms. */
const REDRAW = 60;

/** What there is to read where the scene has no hand. */
export function handlessText({ names, leftOut }: BodyLoads): string {
  if (names.length === 0) return "This scene has no hand, and nothing in it touches.";
  const more = leftOut === 0 ? "" : ` ${leftOut} more are left out.`;
  return `This scene has no hand. What presses on each body:${more}`;
}

export function forcesPanel(desk: Desk): Panel {
  const { feed } = desk.app;
  const series = new RollingSeries(COLUMNS, SAMPLES, SPAN);
  const row = new Float32Array(COLUMNS);
  const chart = new Chart(series);
  const diagram = new HandDiagram();
  let quantity: Quantity = QUANTITIES[0];
  let hand = 0;
  /** What has rows and curves, and the bodies where these are bodies. */
  let parts: readonly Part[] = DIGIT_PARTS;
  let bodies: BodyLoads | null = null;
  let open = false;
  let drawnAt = 0;

  const unit = h("span", { class: "unit" });
  const legend = h("div", { class: "legend" });
  const none = h("p", { class: "help", hidden: true });
  const restart = () => {
    const curves = quantity.curves(PER_HAND * hand, parts);
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
  const what = select("Plot", [], (id) => {
    quantity = QUANTITIES.find((q) => q.id === id) ?? QUANTITIES[0];
    restart();
  });
  const which = select("Hand", [], (value) => {
    hand = Number(value);
    diagram.build(feed.model?.hands[hand]?.side ?? "right");
    restart();
    write();
  });
  which.element.hidden = true;
  const table = new NumberTable();
  // Made once, so that an explanation stays while figures change under it.
  const cells = STEP_FACTS.map((fact) => ({ fact, value: h("dd", { title: fact.help }) }));
  const facts = h(
    "dl",
    { class: "facts" },
    ...cells.flatMap(({ fact, value }) => [h("dt", { title: fact.help }, fact.name), value]),
  );

  const write = () => {
    const { snapshot } = feed;
    if (snapshot === null) return;
    if (bodies === null) {
      const fingers = snapshot.fingers.subarray(PER_HAND * hand, PER_HAND * (hand + 1));
      diagram.show(fingers);
      table.write(fingers, wholeHand(fingers));
    } else {
      bodies.sums(snapshot, row);
      table.write(row, null);
    }
    for (const { fact, value } of cells) setText(value, fact.value(snapshot));
  };

  /** Rows, curves and choices of a scene. */
  const arrange = (model: SceneModel) => {
    const hands = model.hands.slice(0, HANDS_MOST);
    hand = Math.min(hand, Math.max(0, hands.length - 1));
    which.input.replaceChildren(
      ...hands.map((item, i) => h("option", { value: i }, `${item.name} (${item.side ?? "no side"})`)),
    );
    which.input.value = String(hand);
    which.element.hidden = hands.length < 2;
    diagram.element.toggleAttribute("hidden", hands.length === 0);
    diagram.build(hands[hand]?.side ?? "right");

    bodies = hands.length === 0 ? new BodyLoads(model) : null;
    parts = bodies === null ? DIGIT_PARTS : bodyParts(bodies.names);
    none.hidden = bodies === null;
    setText(none, bodies === null ? "" : handlessText(bodies));
    table.build(parts, bodies === null);
    const choices = QUANTITIES.filter((q) => !q.perPart || parts.length > 0);
    if (!choices.includes(quantity)) [quantity] = choices;
    what.input.replaceChildren(...choices.map(({ id, label }) => h("option", { value: id }, label)));
    what.input.value = quantity.id;
  };

  diagram.show(new Float32Array(PER_HAND));
  feed.on("model", (model) => {
    series.clear();
    arrange(model);
    if (open) restart();
  });
  feed.on("snapshot", (snapshot) => {
    sample(snapshot, row);
    bodies?.sums(snapshot, row);
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
      none,
      what.element,
      chart.element,
      h("p", { class: "caption" }, unit),
      legend,
      table.element,
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
