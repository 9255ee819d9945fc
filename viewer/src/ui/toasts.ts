// Short messages that go away by themselves, read aloud by screen readers.

import { button, h } from "./dom";

export type Tone = "info" | "warning" | "error";

/** What the visitor can do about it, as a button in the message. */
export interface Action {
  readonly label: string;
  readonly act: () => void;
}

const AT_ONCE = 4;

export class Toasts {
  readonly element = h("div", { class: "toasts", role: "status", "aria-live": "polite" });
  private last = { text: "", at: -Infinity };

  /** `always`: it shows on a bare picture, too. */
  show(text: string, tone: Tone = "info", action: Action | null = null, always = false): void {
    const now = performance.now();
    if (text === this.last.text && now - this.last.at < 2000) return;
    this.last = { text, at: now };
    // The same words are not stacked: the newest stays longest.
    for (const old of [...this.element.children]) {
      if (old instanceof HTMLElement && old.dataset["text"] === text) old.remove();
    }
    const toast = h("div", { class: `toast ${tone}${always ? " always" : ""}`, "data-text": text, "data-action": action?.label ?? "" }, h("span", {}, text));
    if (action !== null) {
      const act = () => {
        toast.remove();
        action.act();
      };
      toast.append(button(action.label, act, { class: "primary" }));
    }
    toast.append(button("×", () => toast.remove(), { class: "plain", "aria-label": "Dismiss" }));
    this.element.append(toast);
    while (this.element.children.length > AT_ONCE) this.element.firstElementChild?.remove();
    // Long enough to read: two seconds and 60 ms per letter.
    const read = tone === "info" ? 2000 + 60 * text.length : 6000 + 80 * text.length;
    // A button gives time to decide.
    const stay = action === null ? read : read + 8000;
    setTimeout(() => toast.remove(), stay);
  }

  /** Takes back what offers this action, where there is nothing to do any more. */
  withdraw(label: string): void {
    for (const old of [...this.element.children]) {
      if (old instanceof HTMLElement && old.dataset["action"] === label) old.remove();
    }
  }
}
