// Input source: recorded hands, from a file or built in.

import { Vector3 } from "three";
import type { App } from "../app";
import { InputSourceBase } from "../input/source";
import { BUILTIN_MOTIONS, builtinPose, duration } from "./builtin";
import { newHandJoints } from "./joints";
import { FILE_BYTES_MAX, parseMotion, type Motion, type Track } from "./motion";
import { MotionControls } from "./motion-controls";
import type { Side } from "../protocol/types";
import { HandsRequest, PoseOutlet, SIDES, type Lengths } from "./outlet";
import { moveJoints, type Rigid } from "./rigid";
import { placeMotion, sampleTrack } from "./sample";
import { SizeMedian } from "./size";

export class MotionSource extends InputSourceBase {
  readonly id = "motion";
  readonly label = "Recorded motion";
  readonly help =
    "Plays tracked hands from a file of JSON lines (drop it anywhere on the page) or a motion that comes along.";
  readonly controls: HTMLElement;

  private readonly panel: MotionControls;
  private readonly outlet: PoseOutlet;
  private readonly request: HandsRequest;
  private motion: Motion | null = null;
  private lengths: Lengths = {};
  private place: Rigid | null = null;
  private time = 0;
  private stopHook: (() => void) | null = null;
  private readonly hand = newHandJoints();

  constructor(private readonly app: App) {
    super();
    this.outlet = new PoseOutlet(app.connection);
    this.request = new HandsRequest(app.connection);
    this.panel = new MotionControls(BUILTIN_MOTIONS, {
      file: (file) => void this.load(file),
      chosen: () => this.restart(),
    });
    this.controls = this.panel.element;
    app.connection.on("open", () => this.request.forget());
  }

  /** Reads a capture; what is wrong with it is told by line. */
  async load(file: File): Promise<void> {
    if (file.size > FILE_BYTES_MAX) {
      this.set(this.state, `${file.name} is larger than ${FILE_BYTES_MAX >> 20} MB.`);
      return;
    }
    try {
      this.play(parseMotion(await file.text(), file.name));
    } catch (error) {
      // What played before goes on.
      this.set(this.state, error instanceof Error ? error.message : String(error));
    }
  }

  /** Takes a motion into the list and chooses it. */
  play(motion: Motion): void {
    this.motion = motion;
    this.lengths = {};
    for (const side of SIDES) {
      const track = motion.tracks[side];
      if (track !== undefined) this.lengths[side] = recordedLength(track);
    }
    this.panel.addFile(motion.name);
    const seconds = (motion.end - motion.start).toFixed(1);
    const hands = Object.keys(motion.tracks).join(" and ");
    this.set(this.state, `${motion.name}: ${seconds} s of the ${hands} hand.`);
    this.restart();
  }

  start(): void {
    this.restart();
    this.stopHook = this.app.stage.onFrame((_time, dt) => this.frame(dt));
    this.set("on", this.note);
  }

  stop(): void {
    this.stopHook?.();
    this.stopHook = null;
    this.outlet.lostAll();
    this.request.restore();
    this.set("off", this.note);
  }

  led(): readonly Side[] {
    return this.outlet.led();
  }

  private restart(): void {
    this.time = 0;
    this.place = null;
    this.outlet.lostAll();
  }

  private get centre(): Vector3 {
    const target = this.app.connection.model?.camera?.target;
    return target === undefined ? new Vector3() : new Vector3(...target);
  }

  private frame(dt: number): void {
    this.time += dt * this.panel.speed;
    const builtin = BUILTIN_MOTIONS.find((motion) => motion.id === this.panel.chosen);
    if (builtin !== undefined) {
      if (!this.inTime(duration(builtin))) return;
      for (const hand of this.app.connection.model?.hands ?? []) {
        const pose = builtinPose(builtin, this.time, hand, this.centre);
        if (hand.side !== null) this.outlet.angles(hand.side, pose.wrist, pose.angles);
      }
    } else if (this.motion !== null) {
      this.playFile(this.motion);
    }
  }

  private playFile(motion: Motion): void {
    if (!this.inTime(motion.end - motion.start)) return;
    // A recording brings its hands along, at their size; asked for once.
    if (this.request.ask(this.lengths)) this.place = null;
    this.place ??= placeMotion(motion, this.centre);
    for (const side of SIDES) {
      const track = motion.tracks[side];
      if (track === undefined) continue;
      if (sampleTrack(track, motion.start + this.time, this.hand)) {
        moveJoints(this.hand, this.place);
        this.outlet.joints(side, this.hand);
      } else {
        this.outlet.lost(side);
      }
    }
  }

  /** Starts again at the end, or stops there. */
  private inTime(seconds: number): boolean {
    if (this.time <= seconds) return true;
    if (this.panel.loop) {
      this.restart();
    } else {
      this.app.inputs.stop();
    }
    return false;
  }
}

/** Median length of the recorded hand, m, or null where the recording is too short to tell. */
function recordedLength(track: Track): number | null {
  const median = new SizeMedian();
  track.samples.forEach((sample, i) => median.add(sample, track.times[i]));
  return median.get()?.length ?? null;
}
