// Pictures as numbers, for loose comparison.

import type { Page } from "playwright-core";

const [WIDTH, HEIGHT] = [320, 180];

/** What the stage draws now, red, green, blue and opacity from 0 to 255, small. */
export async function picture(page: Page): Promise<Uint8Array> {
  const base64 = await page.evaluate(
    async ([width, height]) => {
      // Two frames, so that what has just changed is drawn.
      for (let i = 0; i < 2; i++) await new Promise((resolve) => requestAnimationFrame(resolve));
      const blob = await window.thenar.app.stage.screenshot(width, height);
      const canvas = new OffscreenCanvas(width, height);
      const context = canvas.getContext("2d")!;
      context.drawImage(await createImageBitmap(blob), 0, 0, width, height);
      const { data } = context.getImageData(0, 0, width, height);
      let text = "";
      for (const byte of data) text += String.fromCharCode(byte);
      return btoa(text);
    },
    [WIDTH, HEIGHT] as const,
  );
  return new Uint8Array(Buffer.from(base64, "base64"));
}

/** Share of pixels that differ clearly. */
export function difference(a: Uint8Array, b: Uint8Array): number {
  let count = 0;
  for (let i = 0; i < a.length; i += 4) {
    const most = Math.max(...[0, 1, 2].map((k) => Math.abs(a[i + k]! - b[i + k]!)));
    if (most > 12) count += 1;
  }
  return (4 * count) / a.length;
}

/** Shares of pixels that are warm (red over blue), pale, and black. */
export function histogram(pixels: Uint8Array): { warm: number; pale: number; black: number } {
  const sum = { warm: 0, pale: 0, black: 0 };
  for (let i = 0; i < pixels.length; i += 4) {
    const [r, g, b] = [pixels[i]!, pixels[i + 1]!, pixels[i + 2]!];
    if (r > b + 25) sum.warm += 1;
    if (Math.min(r, g, b) > 170) sum.pale += 1;
    if (Math.max(r, g, b) < 12) sum.black += 1;
  }
  const total = pixels.length / 4;
  return { warm: sum.warm / total, pale: sum.pale / total, black: sum.black / total };
}
