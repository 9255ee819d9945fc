// Keyboard shortcuts in one table, which the help also prints.

export interface Shortcut {
  /** `KeyboardEvent.key`, lower case; "shift+r" with Shift. */
  readonly key: string;
  /** How the help names it, if not by `key`. */
  readonly name?: string;
  readonly label: string;
  readonly group: string;
  readonly act: () => void;
  /** When it counts; always, if absent. */
  readonly when?: () => boolean;
}

/** Sees a key before the shortcuts do; true if it used it. */
export type KeyTaker = (event: KeyboardEvent, down: boolean) => boolean;

export class Keys {
  readonly list: Shortcut[] = [];
  private readonly takers: KeyTaker[] = [];

  constructor() {
    document.addEventListener("keydown", (event) => this.pressed(event));
    document.addEventListener("keyup", (event) => this.takers.forEach((take) => take(event, false)));
  }

  add(shortcut: Shortcut): void {
    this.list.push(shortcut);
  }

  addTaker(taker: KeyTaker): void {
    this.takers.push(taker);
  }

  private pressed(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.defaultPrevented) return;
    if (belongsToField(event) || document.querySelector("dialog[open]") !== null) return;
    if (this.takers.some((take) => take(event, true))) {
      event.preventDefault();
      return;
    }
    if (event.altKey || event.repeat) return;
    const key = event.key.toLowerCase();
    const name = event.shiftKey && /^[a-z]$/.test(key) ? `shift+${key}` : key;
    const found = this.list.find((shortcut) => shortcut.key === name && shortcut.when?.() !== false);
    if (found === undefined) return;
    event.preventDefault();
    found.act();
  }
}

/** Keys that the focused element itself means something by. */
function belongsToField(event: KeyboardEvent): boolean {
  const at = event.target;
  if (at instanceof HTMLSelectElement || at instanceof HTMLTextAreaElement) return event.key !== "Escape";
  if (at instanceof HTMLInputElement) {
    if (at.type === "checkbox" || at.type === "radio")
      return event.key === " " || event.key.startsWith("Arrow");
    if (at.type === "range") return /^(Arrow|Home|End|Page)/.test(event.key);
    return event.key !== "Escape";
  }
  return at instanceof HTMLButtonElement && (event.key === " " || event.key === "Enter");
}
