// A message that cannot be what it claims to be.

export class ProtocolError extends Error {
  override readonly name = "ProtocolError";
}

export function check(good: boolean, message: string): asserts good {
  if (!good) throw new ProtocolError(message);
}
