// The contacts of a snapshot, read in place.

import type { Contacts, Numbers3 } from "./types";

/** 32-bit words of a contact. */
export const CONTACT_WORDS = 12;
/** Where its place, force, normal, area, slip speed and gap begin, in words. */
const [PLACE, FORCE, NORMAL, AREA, SLIP, GAP] = [2, 5, 8, 9, 10, 11];
/** One, in the numbers of a normal. */
const UNIT = 32767;

export class ContactTable implements Contacts {
  private readonly halves: Uint16Array;
  private readonly signed: Int16Array;
  private readonly numbers: Float32Array;

  constructor(
    readonly count: number,
    bytes: ArrayBuffer,
    at: number,
  ) {
    this.halves = new Uint16Array(bytes, at, 2 * CONTACT_WORDS * count);
    this.signed = new Int16Array(bytes, at, 2 * CONTACT_WORDS * count);
    this.numbers = new Float32Array(bytes, at, CONTACT_WORDS * count);
  }

  bodyA(i: number): number {
    return this.halves[2 * CONTACT_WORDS * i];
  }

  bodyB(i: number): number {
    return this.halves[2 * CONTACT_WORDS * i + 1];
  }

  vertexA(i: number): number {
    return this.halves[2 * CONTACT_WORDS * i + 2];
  }

  vertexB(i: number): number {
    return this.halves[2 * CONTACT_WORDS * i + 3];
  }

  place(i: number, out: Numbers3): void {
    this.vector(i, PLACE, out);
  }

  force(i: number, out: Numbers3): void {
    this.vector(i, FORCE, out);
  }

  /** From the octahedron |x| + |y| + |z| = 1, whose lower half is folded over the upper one. */
  normal(i: number, out: Numbers3): void {
    const at = 2 * (CONTACT_WORDS * i + NORMAL);
    const [u, v] = [this.signed[at] / UNIT, this.signed[at + 1] / UNIT];
    const z = 1 - Math.abs(u) - Math.abs(v);
    const folded = Math.max(-z, 0);
    const x = u - (u < 0 ? -folded : folded);
    const y = v - (v < 0 ? -folded : folded);
    const length = Math.hypot(x, y, z);
    out.x = x / length;
    out.y = y / length;
    out.z = z / length;
  }

  normalForce(i: number): number {
    this.normal(i, N);
    this.force(i, F);
    return F.x * N.x + F.y * N.y + F.z * N.z;
  }

  area(i: number): number {
    return this.numbers[CONTACT_WORDS * i + AREA];
  }

  slip(i: number): number {
    return this.numbers[CONTACT_WORDS * i + SLIP];
  }

  gap(i: number): number {
    return this.numbers[CONTACT_WORDS * i + GAP];
  }

  private vector(i: number, word: number, out: Numbers3): void {
    const at = CONTACT_WORDS * i + word;
    out.x = this.numbers[at];
    out.y = this.numbers[at + 1];
    out.z = this.numbers[at + 2];
  }
}

const N = { x: 0, y: 0, z: 0 };
const F = { x: 0, y: 0, z: 0 };
