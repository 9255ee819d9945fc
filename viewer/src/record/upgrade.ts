// Messages of older protocols as those of today, so that recordings of before open.

import { PER_DIGIT, PER_HAND, PROTOCOL_VERSION } from "../protocol/types";

const HEADER = 88;
/** Where a snapshot counts rigid bodies, nodes, targets, contacts and hands. */
const COUNTS_AT = 64;
const CONTACTS_AT = 76;
const CONTACT_BYTES = 48;
/** Per digit normal and shear force and area, until protocol 2. */
const PER_DIGIT_BEFORE = 3;
const PER_HAND_BEFORE = (PER_HAND / PER_DIGIT) * PER_DIGIT_BEFORE;

export interface Upgraded {
  readonly message: ArrayBuffer;
  /** Contacts were left out: those of protocol 1 had no normals. */
  readonly lacks: boolean;
}

/** The message itself where it is of today's protocol or of one not known. Pressures, which came with
 * protocol 3, become force over area, as pages showed them before. */
export function upgrade(message: ArrayBuffer, isModel: boolean): Upgraded {
  const version = new DataView(message).getUint8(1);
  if (version !== 1 && version !== 2) return { message, lacks: false };
  const known = isModel || message.byteLength < HEADER;
  const out = known ? message.slice(0) : withPressures(message, version === 1);
  new DataView(out).setUint8(1, PROTOCOL_VERSION);
  return { message: out, lacks: version === 1 };
}

function withPressures(message: ArrayBuffer, bare: boolean): ArrayBuffer {
  const view = new DataView(message);
  const count = (k: number) => view.getUint32(COUNTS_AT + 4 * k, true);
  const [rigids, nodes, targets, contacts, hands] = [0, 1, 2, 3, 4].map(count);
  const before = HEADER + 4 * (7 * rigids + 3 * nodes + 7 * targets);
  const after = before + 4 * PER_HAND_BEFORE * hands;
  const end = after + CONTACT_BYTES * contacts;
  // What does not add up is refused where it is read.
  if (end !== message.byteLength) return message.slice(0);
  const kept = bare ? after : end;
  const out = new Uint8Array(before + 4 * PER_HAND * hands + (kept - after));
  out.set(new Uint8Array(message, 0, before));
  out.set(new Uint8Array(message, after, kept - after), before + 4 * PER_HAND * hands);
  const write = new DataView(out.buffer);
  for (let digit = 0; digit < (PER_HAND / PER_DIGIT) * hands; digit++) {
    const told = [0, 1, 2].map((k) => view.getFloat32(before + 4 * (PER_DIGIT_BEFORE * digit + k), true));
    const [normal, , area] = told;
    const figures = [...told, area > 0 ? normal / area : 0];
    figures.forEach((figure, k) => write.setFloat32(before + 4 * (PER_DIGIT * digit + k), figure, true));
  }
  if (bare) write.setUint32(CONTACTS_AT, 0, true);
  return out.buffer;
}
