// A small board behind the scene: force per finger of each hand, how close to real time the
// simulation runs, and one line of advice.

import { CanvasTexture, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace, Vector3 } from "three";
import { DIGITS, type Side } from "../protocol/types";
import { forceShare } from "./forces";

export interface PanelData {
  readonly forces: Readonly<Record<Side, readonly number[] | null>>;
  /** Simulated over real time; null without a simulation. */
  readonly speed: number | null;
  readonly advice: string;
}

const [WIDTH, HEIGHT] = [512, 288];
/** m */
const BOARD_WIDTH = 0.4;
/** Redrawn at most this often, s. */
const EVERY_S = 0.2;
const FONT = "system-ui, sans-serif";

export class XrPanel {
  readonly mesh: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly canvas = document.createElement("canvas");
  private readonly texture: CanvasTexture;
  private drawn = -Infinity;

  constructor() {
    this.canvas.width = WIDTH;
    this.canvas.height = HEIGHT;
    this.texture = new CanvasTexture(this.canvas);
    this.texture.colorSpace = SRGBColorSpace;
    const geometry = new PlaneGeometry(BOARD_WIDTH, (BOARD_WIDTH * HEIGHT) / WIDTH);
    this.mesh = new Mesh(geometry, new MeshBasicMaterial({ map: this.texture, toneMapped: false }));
  }

  /** Behind the middle of the scene, leaning back to face the visitor's eyes. */
  place(centre: Vector3): void {
    this.mesh.position.set(centre.x, 0.2, centre.z - 0.3);
    this.mesh.rotation.set(-0.35, 0, 0);
  }

  /** `time` in seconds. */
  draw(data: PanelData, time: number): void {
    if (time - this.drawn < EVERY_S) return;
    const context = this.canvas.getContext("2d");
    if (context === null) return;
    this.drawn = time;
    context.fillStyle = "#14181d";
    context.fillRect(0, 0, WIDTH, HEIGHT);
    drawHand(context, "Left", data.forces.left, 16);
    drawHand(context, "Right", data.forces.right, WIDTH / 2 + 8);
    context.fillStyle = "#e8edf2";
    context.font = `22px ${FONT}`;
    if (data.speed !== null) context.fillText(`Real time × ${data.speed.toFixed(2)}`, 16, HEIGHT - 48);
    context.fillStyle = "#ffd479";
    context.fillText(data.advice, 16, HEIGHT - 16, WIDTH - 32);
    this.texture.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.texture.dispose();
  }
}

function drawHand(
  context: CanvasRenderingContext2D,
  title: string,
  forces: readonly number[] | null,
  x: number,
): void {
  context.fillStyle = "#e8edf2";
  context.font = `600 22px ${FONT}`;
  context.fillText(forces === null ? `${title}: none` : `${title}, N`, x, 30);
  context.font = `19px ${FONT}`;
  forces?.forEach((force, digit) => {
    const y = 58 + 27 * digit;
    context.fillStyle = "#e8edf2";
    context.fillText(DIGITS[digit], x, y);
    context.fillText(force.toFixed(1), x + 72, y);
    const share = forceShare(force);
    context.fillStyle = `hsl(${Math.round(130 * (1 - share))} 70% 50%)`;
    context.fillRect(x + 116, y - 14, 110 * share, 15);
  });
}
