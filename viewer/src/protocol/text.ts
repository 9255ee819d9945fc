// Text messages of the server: JSON with a known `type`.

import { check } from "./check";
import type { ServerText } from "./types";

const FIELDS = {
  welcome: ["protocol", "server", "client", "scenes"],
  status: ["control", "viewers", "paused", "speed", "scene", "loading", "hands", "settings"],
  error: ["message"],
  pong: ["t", "server"],
  touch: [
    "state",
    "reason",
    "armed_by",
    "rate",
    "ticks",
    "missed",
    "period_p999_us",
    "devices",
    "hands",
    "warnings",
    "messages",
    "statement",
  ],
} as const;

/** Reads one text message; null for a type this page does not know (a newer server's). */
export function decodeText(text: string): ServerText | null {
  let json: unknown;
  try {
    json = JSON.parse(text);
  } catch {
    check(false, "A text message is no JSON.");
  }
  check(typeof json === "object" && json !== null && "type" in json, "A text message has no type.");
  const type = String(json.type);
  if (!Object.hasOwn(FIELDS, type)) return null;
  for (const field of FIELDS[type as keyof typeof FIELDS]) {
    check(field in json, `A ${type} message lacks ${field}.`);
  }
  return json as ServerText;
}
