// Reads the server's binary messages. Arrays are views of the message, not copies; every length,
// count and index is checked first, so that what comes out may be relied upon when drawing.

import { check, ProtocolError } from "./check";
import { PROTOCOL_VERSION, type SceneModel, type Snapshot } from "./types";
import { decodeModel } from "./model";
import { decodeSnapshot } from "./snapshot";

export const KIND = { model: 1, snapshot: 2 } as const;

export type Message =
  | { readonly kind: "model"; readonly model: SceneModel }
  | { readonly kind: "snapshot"; readonly snapshot: Snapshot }
  /** A snapshot of a model that is not there any more, or not yet. */
  | { readonly kind: "stale" };

/** Reads one message. `model` is the one in force. Throws `ProtocolError`. */
export function decode(bytes: ArrayBuffer, model: SceneModel | null, now: number): Message {
  check(bytes.byteLength >= 8, `A message of ${bytes.byteLength} bytes has no header.`);
  const view = new DataView(bytes);
  const kind = view.getUint8(0);
  const version = view.getUint8(1);
  check(
    version === PROTOCOL_VERSION,
    `The server speaks protocol ${version}, this page ${PROTOCOL_VERSION}. Reload the page.`,
  );
  const epoch = view.getUint32(4, true);
  switch (kind) {
    case KIND.model:
      return { kind: "model", model: decodeModel(bytes, epoch) };
    case KIND.snapshot:
      if (model === null || model.epoch !== epoch) return { kind: "stale" };
      return { kind: "snapshot", snapshot: decodeSnapshot(bytes, model, now) };
    default:
      throw new ProtocolError(`A message of unknown kind ${kind}.`);
  }
}
