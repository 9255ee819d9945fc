// Input source: a headset that tracks hands or controllers, through WebXR.

import type { App } from "../app";
import { InputSourceBase } from "../input/source";
import { button, h } from "../ui/dom";
import type { Side } from "../protocol/types";
import { SIDES } from "../tracking/outlet";
import type { Emulator } from "./emulate";
import { XrLive } from "./session";

type Mode = "immersive-vr" | "immersive-ar";

interface Words {
  readonly id: string;
  readonly label: string;
  readonly help: string;
}

const WORDS: Readonly<Record<Mode, Words>> = {
  "immersive-vr": {
    id: "xr",
    label: "Enter XR",
    help: "Headset: the scene stands on a table before you, at true scale, and both of your hands reach in, bare or with controllers.",
  },
  "immersive-ar": {
    id: "xr-ar",
    label: "Enter XR in your room",
    help: "The same, with the room around you in view.",
  },
};

export class XrSource extends InputSourceBase {
  readonly id: string;
  readonly label: string;
  readonly stopLabel = "Leave XR";
  readonly help: string;
  readonly controls: HTMLElement;
  live: XrLive | null = null;
  /** Set while a headset is emulated. */
  emulator: Emulator | null = null;
  private detach: (() => void) | null = null;
  private readonly recentreButton: HTMLButtonElement;

  constructor(
    protected readonly app: App,
    readonly mode: Mode,
    words: Words = WORDS[mode],
  ) {
    super();
    ({ id: this.id, label: this.label, help: this.help } = words);
    this.recentreButton = button("Bring the scene before me", () => this.live?.recentre(), {
      hidden: true,
    });
    this.controls = h("div", { class: "xr-controls" }, this.recentreButton);
    app.stage.canvas.addEventListener("webglcontextlost", () => {
      if (this.live !== null) this.end("The graphics were lost. Enter again.");
    });
    navigator.xr?.addEventListener?.("devicechange", () => void this.probe());
  }

  /** Asks the browser whether it has such a device; after an emulated one came, again. */
  async probe(): Promise<void> {
    if (!window.isSecureContext) {
      this.setAvailable(false, "XR needs a secure address: https, or localhost.");
      return;
    }
    const supported = await navigator.xr?.isSessionSupported(this.mode).catch(() => false);
    if (supported === true) this.setAvailable(true);
    else this.setAvailable(false, "This browser sees no XR headset.");
  }

  async start(): Promise<void> {
    const { xr } = navigator;
    if (xr === undefined) throw new Error("This browser has no WebXR.");
    this.set("starting", "Waiting for the headset.");
    let session: XRSession;
    try {
      session = await xr.requestSession(this.mode, {
        requiredFeatures: ["local"],
        optionalFeatures: ["local-floor", "hand-tracking"],
      });
    } catch (error) {
      const reason = error instanceof Error ? error.message : String(error);
      this.set("failed", `The headset did not start: ${reason}`);
      return;
    }
    const floorKnown = await this.present(session);
    const transparent = session.environmentBlendMode !== "opaque";
    this.detach = this.emulator?.attach(() => this.app.inputs.stop()) ?? null;
    const live = new XrLive(this.app, session, floorKnown, transparent);
    this.live = live;
    session.addEventListener("end", () => this.ended(live));
    this.recentreButton.hidden = false;
    const enabled = session.enabledFeatures;
    const hands = enabled === undefined || enabled.includes("hand-tracking");
    this.set("on", hands ? "" : "The headset does not let the page track hands: take the controllers.");
  }

  stop(): void {
    this.end("");
  }

  led(): readonly Side[] {
    return this.live?.led() ?? [];
  }

  /** Draws into the session; true if its floor is known. */
  private async present(session: XRSession): Promise<boolean> {
    const { xr } = this.app.stage.renderer;
    const floor = await session.requestReferenceSpace("local-floor").then(
      () => true,
      () => false,
    );
    xr.enabled = true;
    xr.setReferenceSpaceType(floor ? "local-floor" : "local");
    await xr.setSession(session);
    return floor;
  }

  private end(note: string): void {
    const session = this.live?.session;
    this.letGo(note);
    session?.end().catch(() => undefined);
  }

  private ended(live: XrLive): void {
    if (this.live === live) this.letGo("");
    // After three's own handling of the end.
    setTimeout(() => live.restoreCamera(), 0);
  }

  private letGo(note: string): void {
    this.live?.dispose();
    this.live = null;
    this.detach?.();
    this.detach = null;
    this.recentreButton.hidden = true;
    this.set("off", note);
  }

  /** For tests and the curious. */
  get report(): XrReport {
    const { live } = this;
    return {
      running: live !== null,
      frames: live?.frames ?? 0,
      tracked: live?.seen() ?? [],
      lengths: Object.fromEntries(
        SIDES.map((side) => [side, live?.sizing.size(side)?.length ?? null] as const),
      ),
      thickness: Object.fromEntries(
        SIDES.map((side) => [side, live?.sizing.size(side)?.thickness ?? null] as const),
      ),
    };
  }
}

/** The same without a headset: the emulated one comes first. */
export class EmulatedSource extends XrSource {
  constructor(
    app: App,
    private readonly emulate: () => Promise<Emulator>,
  ) {
    super(app, "immersive-vr", {
      id: "xr-emulated",
      label: "Emulate a headset",
      help: "Tries out XR without a headset: mouse and keys move two tracked hands that can pinch, or two controllers.",
    });
  }

  /** Always to be had. */
  override probe(): Promise<void> {
    return Promise.resolve();
  }

  override async start(): Promise<void> {
    this.set("starting", "Loading the emulator.");
    this.emulator = await this.emulate();
    await super.start();
  }
}

export interface XrReport {
  readonly running: boolean;
  readonly frames: number;
  readonly tracked: readonly string[];
  /** Of the wearer's hands as measured, m. */
  readonly lengths: Readonly<Record<string, number | null>>;
  /** Relative to the model's hand of the same length. */
  readonly thickness: Readonly<Record<string, number | null>>;
}
