// Mouse and keys for the hands and controllers of an emulated headset.

import { Quaternion, Vector3 } from "three";
import type { Side } from "../protocol/types";
import { button, h } from "../ui/dom";
import type { Emulator } from "./emulate";

/** m per pixel of the mouse, m per notch of the wheel, m per key press. */
const PER_PIXEL = 0.0008;
const PER_NOTCH = 0.0002;
const PER_KEY = 0.01;
/** rad per pixel. */
const TURN_PER_PIXEL = 0.006;

const HELP =
  "Drag: hand left, right, up, down. Wheel: to and fro. Shift-drag: turn. Space: pinch, or trigger and grip button. C: hands or controllers. Tab: other hand. Arrows, Page up and down: small steps. Esc: leave.";

const STEPS: Readonly<Record<string, readonly [number, number, number]>> = {
  ArrowLeft: [-PER_KEY, 0, 0],
  ArrowRight: [PER_KEY, 0, 0],
  ArrowUp: [0, 0, -PER_KEY],
  ArrowDown: [0, 0, PER_KEY],
  PageUp: [0, PER_KEY, 0],
  PageDown: [0, -PER_KEY, 0],
};

export class EmulatorControls {
  private side: Side = "right";
  private readonly word = h("strong", {}, "Right hand");

  constructor(private readonly emulator: Emulator) {}

  /** Listens while the emulated session shows `container`. */
  attach(container: HTMLElement, leave: () => void): () => void {
    const board = h(
      "div",
      { class: "emulator-help", role: "note" },
      this.word,
      h("span", {}, HELP),
      button("Leave XR", leave),
    );
    container.classList.add("emulator");
    container.append(board);
    const stop = new AbortController();
    const options = { signal: stop.signal, capture: true };
    window.addEventListener("keydown", (event) => this.key(event, leave), options);
    window.addEventListener("keyup", (event) => this.keyUp(event), options);
    container.addEventListener("pointermove", (event) => this.drag(event), options);
    container.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.shift(0, 0, PER_NOTCH * event.deltaY);
      },
      { ...options, passive: false },
    );
    return () => {
      stop.abort();
      board.remove();
    };
  }

  private shift(x: number, y: number, z: number): void {
    const { position } = this.emulator.moved(this.side);
    position.set(position.x + x, position.y + y, position.z + z);
  }

  private drag(event: PointerEvent): void {
    if (event.buttons === 0) return;
    const { movementX: x, movementY: y } = event;
    if (!event.shiftKey) {
      this.shift(PER_PIXEL * x, -PER_PIXEL * y, 0);
      return;
    }
    const { quaternion: q } = this.emulator.moved(this.side);
    const turned = new Quaternion()
      .setFromAxisAngle(new Vector3(0, 1, 0), -TURN_PER_PIXEL * x)
      .multiply(new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), -TURN_PER_PIXEL * y))
      .multiply(new Quaternion(q.x, q.y, q.z, q.w))
      .normalize();
    q.set(turned.x, turned.y, turned.z, turned.w);
  }

  private key(event: KeyboardEvent, leave: () => void): void {
    const step = STEPS[event.key];
    if (step !== undefined) this.shift(...step);
    else if (event.key === " ") this.close(1);
    else if (event.key === "c") this.emulator.hold(!this.emulator.holds);
    else if (event.key === "Tab") this.change();
    else if (event.key === "Escape") leave();
    else return;
    // The keys mean these things only while in XR; the panels below do not hear them.
    event.preventDefault();
    event.stopPropagation();
  }

  private keyUp(event: KeyboardEvent): void {
    if (event.key === " ") this.close(0);
  }

  private close(amount: number): void {
    if (!this.emulator.holds) {
      this.emulator.pinch(this.side, amount);
      return;
    }
    this.emulator.press(this.side, "trigger", amount);
    this.emulator.press(this.side, "squeeze", amount);
  }

  private change(): void {
    this.side = this.side === "right" ? "left" : "right";
    this.word.textContent = this.side === "right" ? "Right hand" : "Left hand";
  }
}
