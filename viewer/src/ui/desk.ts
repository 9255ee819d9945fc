// What every panel gets, and what it gives.

import type { App } from "../app";
import type { Command } from "../protocol/types";
import type { Keys } from "./keys";
import type { Toasts } from "./toasts";

export interface Desk {
  readonly app: App;
  readonly keys: Keys;
  readonly toasts: Toasts;
}

export interface Panel {
  /** Short, stable: "forces". */
  readonly id: string;
  readonly title: string;
  /** Path of its icon in a 24 × 24 box. */
  readonly icon: string;
  readonly body: HTMLElement;
  /** Called when it opens; panels that cost something to draw rest while closed. */
  shown?(open: boolean): void;
}

/** Sends a command, or says why it cannot be. */
export function command(desk: Desk, what: Command): boolean {
  const { connection } = desk.app;
  const holder = connection.status?.control ?? null;
  if (what.type !== "control" && what.type !== "stop" && holder !== null && !connection.inControl) {
    desk.toasts.show(`You are watching; viewer ${holder} holds control. Take it in the Run panel.`, "warning");
    return false;
  }
  if (connection.send(what)) return true;
  desk.toasts.show("There is no connection to the simulation; it is being tried again.", "warning");
  return false;
}
