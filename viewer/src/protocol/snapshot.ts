// A snapshot: fixed header, then arrays whose sizes the model fixes.

import { check } from "./check";
import { CONTACT_WORDS, ContactTable } from "./contacts";
import { PER_HAND, type SceneModel, type Snapshot } from "./types";

const HEADER = 88;
const MAX_CONTACTS = 512;

export function decodeSnapshot(bytes: ArrayBuffer, model: SceneModel, now: number): Snapshot {
  check(bytes.byteLength >= HEADER, `A snapshot of ${bytes.byteLength} bytes is cut off.`);
  const view = new DataView(bytes);
  const u32 = (at: number) => view.getUint32(at, true);
  const f32 = (at: number) => view.getFloat32(at, true);

  const [rigids, nodes, targets, contacts, hands] = [u32(64), u32(68), u32(72), u32(76), u32(80)];
  const fits =
    rigids === model.rigids.length &&
    nodes === model.node_count &&
    targets === model.target_count &&
    hands === model.hands.length;
  check(fits, "A snapshot counts other bodies than its model.");
  check(contacts <= MAX_CONTACTS, `A snapshot with ${contacts} contacts.`);
  const words = 7 * rigids + 3 * nodes + 7 * targets + PER_HAND * hands + CONTACT_WORDS * contacts;
  check(
    bytes.byteLength === HEADER + 4 * words,
    `A snapshot of ${bytes.byteLength} bytes instead of ${HEADER + 4 * words}.`,
  );

  let at = HEADER;
  const take = (count: number) => {
    const array = new Float32Array(bytes, at, count);
    at += 4 * count;
    return array;
  };
  const rigidPoses = take(7 * rigids);
  const nodePositions = take(3 * nodes);
  const targetPoses = take(7 * targets);
  const fingers = take(PER_HAND * hands);
  return {
    epoch: u32(4),
    flags: view.getUint16(2, true),
    number: u32(8),
    steps: u32(12),
    time: view.getFloat64(16, true),
    stepCost: f32(24),
    stepBudget: f32(28),
    speed: f32(32),
    energy: { total: f32(36), kinetic: f32(40), elastic: f32(44) },
    penetration: f32(48),
    jointGap: f32(52),
    poseNumber: u32(56),
    sweeps: u32(60),
    rigids: rigidPoses,
    nodes: nodePositions,
    targets: targetPoses,
    fingers,
    contacts: new ContactTable(contacts, bytes, at),
    bytes: bytes.byteLength,
    received: now,
  };
}
