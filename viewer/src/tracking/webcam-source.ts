// Input source: hands seen by a webcam. Pictures stay in the browser; another thread looks at them.

import { Vector3 } from "three";
import type { App } from "../app";
import { InputSourceBase } from "../input/source";
import type { Side } from "../protocol/types";
import { h } from "../ui/dom";
import { fixed } from "../ui/format";
import { slider } from "../ui/widgets";
import { openCamera } from "./camera";
import type { TrackedHand } from "./hand-messages";
import { HandTracker, HandTrackerOnce } from "./hand-tracker";
import { OneEuro } from "./one-euro";
import { HandsRequest, PoseOutlet, SIDES } from "./outlet";
import { PictureTime } from "./picture-time";
import { placeWebcamHand, seen, type Seen } from "./webcam-hand";

/** Below this the tracker is not sure which hand, or whether it is one. */
const SCORE_MIN = 0.7;
/** Not seen for so long, a hand is lost, s. */
const LOST_S = 0.25;
/** Seen for so long, a hand that the scene lacks is asked for, s. */
const WANTED_S = 1.5;
const TILT_DEGREES = 75;

const SHAPE = { cutoff: 2.5, beta: 20, speedCutoff: 1 };
const PLACE = { cutoff: 1.2, beta: 6, speedCutoff: 1 };

class WebcamHand {
  readonly shape = new OneEuro(63, SHAPE);
  readonly place = new OneEuro(3, PLACE);
  /** When last seen, and since when without a break, s. */
  last = -Infinity;
  since = 0;

  filter(from: Seen, time: number): Seen {
    if (time - this.last > LOST_S) {
      this.shape.reset();
      this.place.reset();
      this.since = time;
    }
    this.last = time;
    const wrist = Float64Array.from(from.wrist);
    this.shape.filter(from.points, time);
    this.place.filter(wrist, time);
    return { points: from.points, wrist: new Vector3().fromArray(wrist) };
  }
}

export class WebcamSource extends InputSourceBase {
  readonly id = "webcam";
  readonly label = "Webcam";
  readonly help =
    "Your hand before the camera moves the simulated one. Pictures never leave this browser; loads 16 MB once.";
  readonly controls: HTMLElement;
  /** Pictures looked at since the start. */
  pictures = 0;

  private readonly outlet: PoseOutlet;
  private readonly request: HandsRequest;
  private readonly video = h("video", { muted: true, playsinline: true, "aria-label": "Webcam, mirrored" });
  private readonly preview = h("div", { class: "webcam-preview", hidden: true }, this.video);
  /** How far the palm is turned down, degrees. */
  private tilt = TILT_DEGREES;
  private readonly tracker = new HandTrackerOnce(() => HandTracker.load(new URL("mediapipe/", document.baseURI).href));
  private looking = Promise.resolve();
  private stream: MediaStream | null = null;
  /** Counts starts, so that what an old one still awaits is dropped. */
  private run = 0;
  private readonly seenHands: Record<Side, WebcamHand> = {
    left: new WebcamHand(),
    right: new WebcamHand(),
  };
  private distance: number | null = null;
  /** What is in sight, in words. */
  private words = "";
  private readonly pace = new PictureTime();

  constructor(private readonly app: App) {
    super();
    this.outlet = new PoseOutlet(app.connection);
    this.request = new HandsRequest(app.connection);
    const range = { min: 0, max: 90, scale: "linear" } as const;
    const tilt = slider(
      "Palm turned down",
      range,
      (degrees) => `${fixed(degrees, 0)}°`,
      (degrees) => (this.tilt = degrees),
    );
    tilt.set(this.tilt);
    this.controls = h("div", { class: "webcam-controls" }, this.preview, tilt.element);
    app.connection.on("open", () => this.request.forget());
    if (!window.isSecureContext || navigator.mediaDevices === undefined) {
      this.setAvailable(false, "Cameras need a secure address: https, or localhost.");
    }
  }

  async start(): Promise<void> {
    this.run += 1;
    const { run } = this;
    this.distance = null;
    this.pictures = 0;
    this.pace.reset();
    try {
      this.set("starting", "Waiting for the camera.");
      const stream = await openCamera();
      if (run !== this.run) {
        for (const track of stream.getTracks()) track.stop();
        return;
      }
      this.stream = stream;
      stream.getVideoTracks()[0]?.addEventListener("ended", () => this.fail("The camera is gone."));
      this.video.srcObject = stream;
      await this.video.play();
      this.preview.hidden = false;
      this.set("starting", "Loading the hand tracker.");
      await this.tracker.get();
      if (run !== this.run) return;
      this.words = "Show a hand to the camera.";
      this.set("on", this.words);
      // The picture of a run before may still be looked at.
      this.looking = this.looking.then(() => this.look(run));
    } catch (error) {
      if (run !== this.run) return;
      this.fail(error instanceof Error ? error.message : String(error));
    }
  }

  stop(): void {
    this.letGo();
    this.set("off");
  }

  led(): readonly Side[] {
    return this.outlet.led();
  }

  private fail(note: string): void {
    this.letGo();
    this.set("failed", note);
  }

  private letGo(): void {
    this.run += 1;
    for (const track of this.stream?.getTracks() ?? []) track.stop();
    this.stream = null;
    this.video.srcObject = null;
    this.preview.hidden = true;
    this.outlet.lostAll();
    this.request.restore();
  }

  /** One picture after the other, each when the one before is done and a frame has passed. */
  private async look(run: number): Promise<void> {
    while (run === this.run) {
      try {
        const tracker = await this.tracker.get();
        if (this.video.readyState >= HTMLMediaElement.HAVE_CURRENT_DATA) {
          const before = performance.now();
          const hands = await tracker.look(await createImageBitmap(this.video), before);
          if (run !== this.run) return;
          this.pace.add((performance.now() - before) / 1000);
          this.results(hands);
          this.sayPace();
        }
      } catch (error) {
        // A tracker that broke is made anew the next time.
        this.tracker.drop();
        if (run !== this.run) return;
        this.fail(`The hand tracker stopped: ${error instanceof Error ? error.message : String(error)}`);
        return;
      }
      await new Promise((resolve) => requestAnimationFrame(resolve));
    }
  }

  private results(hands: readonly TrackedHand[]): void {
    if (this.stream === null) return;
    this.pictures += 1;
    const time = performance.now() / 1000;
    const aspect = this.video.videoWidth / this.video.videoHeight;
    const found = new Set<Side>();
    hands.forEach(({ side, score, picture, metres }) => {
      if (score < SCORE_MIN || found.has(side)) return;
      const from = seen(picture, metres, aspect);
      if (from === null) return;
      found.add(side);
      this.moved(side, this.seenHands[side].filter(from, time));
    });
    this.others(found, time);
  }

  private moved(side: Side, from: Seen): void {
    // Where the hand first shows is the middle.
    this.distance ??= from.wrist.z;
    const { model } = this.app.connection;
    const hand = model?.hands.find((candidate) => candidate.side === side);
    if (!model || hand === undefined) return;
    const target = model.camera?.target;
    const joints = placeWebcamHand(from, side, {
      centre: target === undefined ? new Vector3() : new Vector3(...target),
      distance: this.distance,
      tilt: (this.tilt * Math.PI) / 180,
      length: hand.length,
    });
    if (joints !== null) this.outlet.joints(side, joints);
  }

  /** Lost hands, hands the scene lacks, and what to tell. */
  private others(found: ReadonlySet<Side>, time: number): void {
    for (const side of SIDES) {
      const hand = this.seenHands[side];
      if (time - hand.last > LOST_S) this.outlet.lost(side);
      const lacking = found.has(side) && !this.outlet.accepts(side);
      if (lacking && time - hand.since > WANTED_S) this.request.ask({ left: null, right: null });
    }
    this.words = found.size === 0 ? "No hand in sight." : `Tracking: ${[...found].join(" and ")} hand.`;
    this.sayPace();
  }

  /** The note, with a remark where tracking is too slow. */
  private sayPace(): void {
    if (this.state !== "on") return;
    const note = this.words + this.pace.remark();
    if (note !== this.note) this.set("on", note);
  }
}
