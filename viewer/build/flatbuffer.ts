// Writes little flatbuffers, as much of the format as model metadata needs (flatbuffers.dev/internals): parents come
// before children, for offsets go forward only.

export type Value =
  | { readonly kind: "u8" | "u32"; readonly value: number }
  /** Fields by their number; null where one is left to its default. */
  | { readonly kind: "table"; readonly fields: readonly (Value | null)[] }
  | { readonly kind: "tables"; readonly items: readonly Value[] }
  | { readonly kind: "floats"; readonly values: readonly number[] }
  | { readonly kind: "bytes"; readonly bytes: Uint8Array }
  | { readonly kind: "text"; readonly text: string }
  /** A place in what follows the written part, bytes from its start. */
  | { readonly kind: "later"; readonly at: number };

export const u8 = (value: number): Value => ({ kind: "u8", value });
export const u32 = (value: number): Value => ({ kind: "u32", value });
export const table = (...fields: (Value | null)[]): Value => ({ kind: "table", fields });
export const tables = (...items: Value[]): Value => ({ kind: "tables", items });
export const floats = (...values: number[]): Value => ({ kind: "floats", values });
export const text = (of: string): Value => ({ kind: "text", text: of });
export const later = (at: number): Value => ({ kind: "later", at });

/** What models ask of the start of their data, bytes. */
const ALIGNMENT = 16;

class Writer {
  readonly out: number[] = [];
  readonly later: { readonly from: number; readonly at: number }[] = [];

  pad(to: number, after = 0): void {
    while ((this.out.length + after) % to !== 0) this.out.push(0);
  }

  number(value: number, size: number): void {
    for (let k = 0; k < size; k++) this.out.push((value >>> (8 * k)) & 255);
  }

  patch(from: number, to: number): void {
    for (let k = 0; k < 4; k++) this.out[from + k] = ((to - from) >>> (8 * k)) & 255;
  }

  /** Writes what offsets refer to, each after the place that refers to it. */
  children(of: readonly { readonly from: number; readonly value: Value }[]): void {
    for (const { from, value } of of) {
      if (value.kind === "later") this.later.push({ from, at: value.at });
      else this.patch(from, this.put(value));
    }
  }

  /** Gives the place of what was written. */
  put(value: Value): number {
    if (value.kind === "table") return this.table(value.fields);
    if (value.kind === "tables") {
      const at = this.start(value.items.length);
      const children = value.items.map((item, i) => ({ from: at + 4 + 4 * i, value: item }));
      value.items.forEach(() => this.number(0, 4));
      this.children(children);
      return at;
    }
    if (value.kind === "floats") {
      const at = this.start(value.values.length);
      this.out.push(...new Uint8Array(Float32Array.from(value.values).buffer));
      return at;
    }
    if (value.kind === "bytes") {
      this.pad(ALIGNMENT, 4);
      const at = this.start(value.bytes.length);
      for (const byte of value.bytes) this.out.push(byte);
      return at;
    }
    if (value.kind !== "text") throw new Error(`${value.kind} stands in a table`);
    const bytes = new TextEncoder().encode(value.text);
    const at = this.start(bytes.length);
    this.out.push(...bytes, 0);
    return at;
  }

  /** A length that begins on four bytes. */
  private start(length: number): number {
    this.pad(4);
    this.number(length, 4);
    return this.out.length - 4;
  }

  private table(fields: readonly (Value | null)[]): number {
    this.pad(4);
    const sheet = this.out.length;
    // Field offsets are counted from the table; each field takes four bytes here.
    const used = fields.map((field, f) => ({ field, place: 4 + 4 * fields.slice(0, f).filter((x) => x !== null).length }));
    const size = 4 + 4 * fields.filter((field) => field !== null).length;
    const length = 4 + 2 * fields.length;
    this.number(length, 2);
    this.number(size, 2);
    for (const { field, place } of used) this.number(field === null ? 0 : place, 2);
    this.pad(4);
    const at = this.out.length;
    this.number(at - sheet, 4);
    const children: { from: number; value: Value }[] = [];
    for (const { field, place } of used) {
      if (field === null) continue;
      const number = field.kind === "u8" || field.kind === "u32";
      this.number(number ? field.value : 0, 4);
      if (!number) children.push({ from: at + place, value: field });
    }
    this.children(children);
    return at;
  }
}

/** A flatbuffer of this root, with `rest` behind it, which `later` values point into. */
export function flatbuffer(root: Value, identifier: string, rest: Uint8Array = new Uint8Array()): Buffer {
  const writer = new Writer();
  writer.number(0, 4);
  writer.out.push(...new TextEncoder().encode(identifier));
  writer.patch(0, writer.put(root));
  writer.pad(ALIGNMENT);
  const end = writer.out.length;
  for (const { from, at } of writer.later) writer.patch(from, end + at);
  return Buffer.concat([Uint8Array.from(writer.out), rest]);
}

/** Reads a table's fields: the place of each, or null where it is left to its default. */
export function fields(bytes: Buffer, at: number, count: number): (number | null)[] {
  const sheet = at - bytes.readInt32LE(at);
  const known = (bytes.readUInt16LE(sheet) - 4) / 2;
  return Array.from({ length: count }, (_, f) => {
    const offset = f < known ? bytes.readUInt16LE(sheet + 4 + 2 * f) : 0;
    return offset === 0 ? null : at + offset;
  });
}

/** Where an offset leads. */
export function follow(bytes: Buffer, at: number): number {
  return at + bytes.readUInt32LE(at);
}

/** Where each element of a vector of tables is. */
export function elements(bytes: Buffer, at: number): number[] {
  return Array.from({ length: bytes.readUInt32LE(at) }, (_, i) => follow(bytes, at + 4 + 4 * i));
}
