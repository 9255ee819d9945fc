// Recorded motion: what is read, what is refused and where, and what plays between samples.

import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { JOINTS, JOINT_NAMES, newHandJoints } from "../../src/tracking/joints";
import { parseMotion } from "../../src/tracking/motion";
import { moveJoints } from "../../src/tracking/rigid";
import { placeMotion, sampleTrack } from "../../src/tracking/sample";
import { SizeMedian } from "../../src/tracking/size";

const HEADER = { format: "hand-joints-jsonl", version: 1, joints: JOINT_NAMES, quat: "x,y,z,w" };

function sample(t: number, x: number, q: number[] = [0, 0, 0, 1], hand = "right"): object {
  return {
    t,
    hand,
    pos: JOINT_NAMES.map((_, joint) => [x, 1, joint]),
    quat: JOINT_NAMES.map(() => q),
    radius: JOINT_NAMES.map(() => 0.01),
  };
}

const file = (...lines: object[]) => lines.map((line) => JSON.stringify(line)).join("\n");
const refusal = (text: string) => {
  try {
    parseMotion(text, "a.jsonl");
  } catch (error) {
    return String(error);
  }
  return "";
};

describe("reading", () => {
  it("reads both hands and their span", () => {
    const motion = parseMotion(file(HEADER, sample(1, 0), sample(1.5, 1), sample(2, 0, undefined, "left")), "a");
    expect([motion.start, motion.end]).toEqual([1, 2]);
    expect(motion.tracks.right?.times).toEqual([1, 1.5]);
    expect(motion.tracks.left?.samples[0][8 * 24 + 2]).toBe(24);
  });

  it("puts joints of another order where they belong", () => {
    const turned = { ...HEADER, joints: [...JOINT_NAMES].reverse() };
    const motion = parseMotion(file(turned, sample(0, 0)), "a");
    expect(motion.tracks.right?.samples[0][2]).toBe(24);
    expect(motion.tracks.right?.samples[0][8 * 24 + 2]).toBe(0);
  });

  it.each([
    ["", "line 1: the first line must be the header"],
    [file(sample(0, 0)), "line 1: header"],
    [file({ ...HEADER, version: 2 }), "line 1: header"],
    [file({ ...HEADER, joints: JOINT_NAMES.slice(1) }), '"joints" must be a list of 25 entries, found 24'],
    [file({ ...HEADER, joints: [...JOINT_NAMES.slice(1), "elbow"] }), 'joint "wrist" is missing'],
    [file(HEADER), "there is no sample"],
    [file(HEADER, sample(0, 0)) + "\n{", "line 3: not JSON"],
    [file(HEADER, sample(0, 0), sample(-1, 0)), "line 3: time of the right hand goes back from 0 s to -1 s"],
    [file(HEADER, sample(0, 500)), "line 2: \"pos of wrist\""],
    [file(HEADER, sample(0, 0, [0, 0, 0, 2])), "line 2: quat of wrist has length 2.00"],
    [file(HEADER, sample(0, 0, undefined, "both")), 'line 2: "hand" must be'],
    [file(HEADER, { ...sample(0, 0), t: "0" }), 'line 2: "t"'],
    [file(HEADER, sample(0, 0)).replace("[0,1,24]", "[0,1]"), "pos of pinky-finger-tip"],
    [file(HEADER, sample(0, 0)) + " ".repeat(70000), "longer than"],
  ])("refuses %#", (text, cause) => expect(refusal(text)).toContain(cause));
});

describe("playing", () => {
  const half: number[] = [0, Math.SQRT1_2, 0, Math.SQRT1_2];
  const track = parseMotion(
    file(HEADER, sample(0, 0), sample(0.05, 1, half), sample(1, 5), sample(1.05, 6)),
    "a",
  ).tracks.right;

  it("goes straight between positions and round between rotations", () => {
    const hand = newHandJoints();
    if (track === undefined) throw new Error("no track");
    expect(sampleTrack(track, 0.025, hand)).toBe(true);
    expect(hand[0]).toBeCloseTo(0.5, 6);
    // Half of a quarter turn about y.
    const eighth = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), Math.PI / 4);
    expect(new Quaternion().fromArray(hand, 3).angleTo(eighth)).toBeLessThan(1e-3);
  });

  it("shows no hand before, after and in a gap", () => {
    const hand = newHandJoints();
    if (track === undefined) throw new Error("no track");
    const seen = [-0.1, 0, 0.05, 0.06, 0.9, 1, 1.05, 1.06].map((t) => sampleTrack(track, t, hand));
    expect(seen).toEqual([false, true, true, false, false, true, true, false]);
  });

  it("starts above the middle of the scene and stays above the table", () => {
    const motion = parseMotion(file(HEADER, sample(0, 0.3), sample(0.1, 0.4)), "a");
    const place = placeMotion(motion, new Vector3(0.02, 0.08, 0.02));
    const hand = motion.tracks.right?.samples[0].slice() ?? newHandJoints();
    moveJoints(hand, place);
    expect([...hand.subarray(0, 3)].map((x) => Number(x.toFixed(6)))).toEqual([0.02, 0.15, 0.12]);
    expect(place.rotation.angleTo(new Quaternion())).toBe(0);
    const low = sample(0.2, 0) as { pos: number[][] };
    low.pos[9][1] = 0.5;
    const deep = placeMotion(parseMotion(file(HEADER, sample(0, 0), low), "a"), new Vector3());
    expect(0.5 + deep.position.y).toBeCloseTo(0, 6);
  });
});

const folder = process.env["THENAR_MOTION_DIR"] ?? "";
const capture = join(folder, "quest3-two-hands-8s.jsonl");
describe.runIf(existsSync(capture))("a capture of a real headset", () => {
  it("plays both hands for its 8.5 s, the left one with one loss of 1 s", () => {
    const motion = parseMotion(readFileSync(capture, "utf8"), "capture");
    const { left, right } = motion.tracks;
    if (left === undefined || right === undefined) throw new Error("a hand is missing");
    expect([left.times.length, right.times.length]).toEqual([667, 756]);
    const hand = newHandJoints();
    let gone = 0;
    for (let t = left.times[0]; t < left.times[left.times.length - 1]; t += 0.01) {
      if (!sampleTrack(left, t, hand)) gone += 0.01;
    }
    expect(Math.abs(gone - 1.01)).toBeLessThan(0.05);
    for (const track of [left, right]) {
      const median = new SizeMedian();
      track.samples.forEach((joints, i) => median.add(joints, track.times[i]));
      // An adult's hand; the emulator's stored hand of the same maker is 0.19 m.
      expect(Math.abs((median.get()?.length ?? 0) - 0.19)).toBeLessThan(0.006);
    }
    expect(right.samples[0].length).toBe(8 * JOINTS);
  });
});
