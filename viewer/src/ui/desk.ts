// What every panel gets, and what it gives.

import type { App } from "../app";
import { ControlHeld } from "../input/source";
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

/** The button of messages about control that lacks. */
export const TAKE_CONTROL = "Take control";

/** Takes control from whoever holds it. */
export function takeControl(desk: Desk): void {
  if (desk.app.connection.send({ type: "control", take: true })) return;
  desk.toasts.show("There is no connection to the simulation; it is being tried again.", "warning");
}

/** Says that another viewer holds control, beside the button that takes it. */
export function sayWatching(desk: Desk): void {
  const holder = desk.app.connection.status?.control ?? null;
  const who = holder === null ? "Nobody holds control." : `Viewer ${holder} holds control.`;
  desk.toasts.show(`${who} You are watching.`, "warning", {
    label: TAKE_CONTROL,
    act: () => takeControl(desk),
  });
}

/** Says why something could not be done; where control is what lacks, with a button to take it. */
export function sayRefused(desk: Desk, error: unknown): void {
  if (error instanceof ControlHeld) sayWatching(desk);
  else desk.toasts.show(error instanceof Error ? error.message : String(error), "error");
}

/** Sends a command, or says why it cannot be. */
export function command(desk: Desk, what: Command): boolean {
  const { connection } = desk.app;
  const holder = connection.status?.control ?? null;
  if (what.type !== "control" && what.type !== "stop" && holder !== null && !connection.inControl) {
    sayWatching(desk);
    return false;
  }
  if (connection.send(what)) return true;
  desk.toasts.show("There is no connection to the simulation; it is being tried again.", "warning");
  return false;
}
