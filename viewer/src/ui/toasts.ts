// Short messages that go away by themselves, read aloud by screen readers.

import { button, h } from "./dom";

export type Tone = "info" | "warning" | "error";

const AT_ONCE = 4;

export class Toasts {
  readonly element = h("div", { class: "toasts", role: "status", "aria-live": "polite" });
  private last = { text: "", at: -Infinity };

  show(text: string, tone: Tone = "info"): void {
    const now = performance.now();
    if (text === this.last.text && now - this.last.at < 2000) return;
    this.last = { text, at: now };
    const toast = h("div", { class: `toast ${tone}` }, h("span", {}, text));
    toast.append(button("×", () => toast.remove(), { class: "plain", "aria-label": "Dismiss" }));
    this.element.append(toast);
    while (this.element.children.length > AT_ONCE) this.element.firstElementChild?.remove();
    // Long enough to read: two seconds and 60 ms per letter.
    const stay = tone === "info" ? 2000 + 60 * text.length : 6000 + 80 * text.length;
    setTimeout(() => toast.remove(), stay);
  }
}
