// The frame around the picture: a bar at the top, the rail of panels at the side (below, on a
// phone), the drawer they open in.

import type { Panel } from "./desk";
import { button, h } from "./dom";
import { icon } from "./icons";
import { isTexts, recall, remember } from "./store";

const NARROW = window.matchMedia("(max-width: 760px)");

export class Shell {
  readonly rail = h("nav", { class: "rail", "aria-label": "Panels" });
  readonly drawer = h("aside", { class: "drawer", "aria-label": "Open panels" });
  private readonly entries: { panel: Panel; tab: HTMLElement; section: HTMLElement }[] = [];
  private readonly open = new Set<string>();

  constructor() {
    NARROW.addEventListener("change", () => {
      // A sheet holds one panel.
      if (NARROW.matches) [...this.open].slice(1).forEach((id) => this.toggle(id, false));
    });
  }

  add(panel: Panel): void {
    const id = `panel-${panel.id}`;
    const tab = h("button", {
      type: "button",
      class: "tab",
      "aria-expanded": "false",
      "aria-controls": id,
      title: panel.title,
    });
    tab.append(icon(panel.icon), h("span", {}, panel.title));
    tab.addEventListener("click", (event) => {
      this.toggle(panel.id);
      // Who opened it by a key goes on in it, past the other buttons; a press has a count of clicks.
      if (event.detail === 0 && this.open.has(panel.id)) section.focus();
    });
    const close = button("×", () => this.toggle(panel.id, false), {
      class: "plain",
      "aria-label": `Close ${panel.title}`,
    });
    const section = h(
      "section",
      { id, class: "panel", "aria-label": `${panel.title} panel`, tabindex: -1, hidden: true },
      h("header", {}, h("h2", {}, panel.title), close),
      panel.body,
    );
    this.rail.append(tab);
    this.drawer.append(section);
    this.entries.push({ panel, tab, section });
  }

  /** Opens what was open last time, or `first` on a wide screen. */
  restore(first: readonly string[]): void {
    if (NARROW.matches) return this.layOut();
    for (const id of recall("panels", isTexts) ?? first) this.toggle(id, true, false);
    this.layOut();
  }

  toggle(id: string, want?: boolean, keep = true): void {
    const entry = this.entries.find(({ panel }) => panel.id === id);
    if (entry === undefined) return;
    const open = want ?? !this.open.has(id);
    if (open && NARROW.matches) {
      for (const other of [...this.open]) if (other !== id) this.toggle(other, false, false);
    }
    if (open) this.open.add(id);
    else this.open.delete(id);
    entry.section.hidden = !open;
    entry.tab.setAttribute("aria-expanded", String(open));
    entry.panel.shown?.(open);
    if (keep) {
      if (!NARROW.matches) remember("panels", [...this.open]);
      if (open) entry.section.scrollIntoView({ block: "nearest" });
      else if (entry.section.contains(document.activeElement)) entry.tab.focus();
    }
    this.layOut();
  }

  /** Hides everything but the picture, or brings it back. */
  hideAll(hidden: boolean): void {
    document.documentElement.classList.toggle("bare", hidden);
  }

  private layOut(): void {
    document.documentElement.classList.toggle("drawer-open", this.open.size > 0);
    this.drawer.hidden = this.open.size === 0;
  }
}
