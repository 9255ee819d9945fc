// What can move the simulated hand: mouse and keys, webcam, headset, a recorded motion. Each is an
// `InputSource`; the registry sees to it that one at a time has the hand, and the Input panel
// draws a button for each.

import type { Side } from "../protocol/types";

export type InputState = "off" | "starting" | "on" | "failed";

export interface InputSource {
  /** Short and stable, as in an address: "mouse", "webcam", "xr". */
  readonly id: string;
  /** On the button. */
  readonly label: string;
  /** On the button while it has the hand; "Stop" and the label, if absent. */
  readonly stopLabel?: string;
  /** One or two plain sentences under the button. */
  readonly help: string;
  readonly state: InputState;
  /** What to tell the visitor now: progress, or why it failed or is not to be had. */
  readonly note: string;
  /** False: the button is greyed and `note` says why. */
  readonly available: boolean;
  /** Controls of its own, shown below the button: a preview, a file chooser. */
  readonly controls?: HTMLElement;
  /** Sides of the hands that it moves at present. */
  led(): readonly Side[];
  /** Starts to send poses. A failure shows in `state` and `note`, or is thrown. */
  start(): void | Promise<void>;
  /** Stops sending; says `sendLost` for the hands it moved. The registry calls the script back. */
  stop(): void;
  /** Calls back whenever state, note or availability change; call what comes back to stop. */
  onChange(listener: () => void): () => void;
}

/** Keeps listeners and state; sources extend it and call `set`. */
export abstract class InputSourceBase implements InputSource {
  abstract readonly id: string;
  abstract readonly label: string;
  abstract readonly help: string;
  state: InputState = "off";
  note = "";
  available = true;
  private readonly listeners = new Set<() => void>();

  abstract start(): void | Promise<void>;
  abstract stop(): void;
  abstract led(): readonly Side[];

  onChange(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  protected set(state: InputState, note = ""): void {
    this.state = state;
    this.note = note;
    this.changed();
  }

  protected setAvailable(available: boolean, note = ""): void {
    this.available = available;
    this.note = note;
    this.changed();
  }

  protected changed(): void {
    for (const listener of [...this.listeners]) listener();
  }
}

/** Another viewer holds control: the hand is theirs until this page takes it. */
export class ControlHeld extends Error {
  constructor() {
    super("Another viewer holds control. Take control first.");
  }
}

/** What the registry needs of the connection. */
export interface ControlLine {
  readonly inControl: boolean;
  /** The server shows a recording, whose hands nothing moves. */
  readonly recorded: boolean;
  /** Asks for control where nobody holds it; true if this page has it or asked for it. */
  askControl(): boolean;
  /** Gives the hands back to the script. */
  script(): void;
}

/** All sources; at most one is active. */
export class InputSources {
  readonly list: InputSource[] = [];
  private readonly listeners = new Set<() => void>();
  private given: InputSource | null = null;

  constructor(private readonly line: ControlLine) {}

  /** The source that has the hand, or null. */
  get active(): InputSource | null {
    return this.given;
  }

  register(source: InputSource): void {
    if (this.find(source.id) !== null) throw new Error(`Input source "${source.id}" is there already.`);
    this.list.push(source);
    source.onChange(() => this.sourceChanged(source));
    this.changed();
  }

  find(id: string): InputSource | null {
    return this.list.find((source) => source.id === id) ?? null;
  }

  /** Gives the hand to a source; the one that had it stops. Throws with a reason for people. */
  async start(id: string): Promise<void> {
    const source = this.find(id);
    if (source === null) throw new Error(`There is no input "${id}".`);
    if (!source.available) throw new Error(source.note || `${source.label} is not available here.`);
    if (this.given === source) return;
    if (this.line.recorded) throw new Error("This is a recording: its hands move as they did.");
    if (!this.line.askControl()) {
      throw new ControlHeld();
    }
    const before = this.given;
    this.given = source;
    if (before !== null) before.stop();
    try {
      await source.start();
    } catch (error) {
      if (this.given === source) this.release();
      throw error;
    }
    this.changed();
  }

  /** Stops the active source and calls the script back. */
  stop(): void {
    const source = this.given;
    if (source === null) return;
    this.given = null;
    source.stop();
    this.callScript();
    this.changed();
  }

  onChange(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  private release(): void {
    this.given = null;
    this.callScript();
  }

  private callScript(): void {
    if (this.line.inControl) this.line.script();
  }

  /** A source that ended by itself (headset taken off, camera unplugged) gives the hand back. */
  private sourceChanged(source: InputSource): void {
    const ended = source.state === "off" || source.state === "failed";
    if (this.given === source && ended) this.release();
    this.changed();
  }

  private changed(): void {
    for (const listener of [...this.listeners]) listener();
  }
}
