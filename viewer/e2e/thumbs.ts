// Takes the small pictures of the scenes that the Run panel shows, from the real page: src/ui/thumbs.

import { mkdirSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { Browser } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { launch, open } from "./support/browser";
import { MOMENTS } from "./support/moments";
import { histogram, picture } from "./support/pixels";
import { Server } from "./support/server";

const folder = fileURLToPath(new URL("../src/ui/thumbs/", import.meta.url));
/** Drawn this much larger, then made smaller: edges are smooth. */
const FINER = 4;
const [WIDTH, HEIGHT] = [160, 100];

let server: Server;
let browser: Browser;

beforeAll(async () => {
  mkdirSync(folder, { recursive: true });
  server = await Server.start("free-motion");
  browser = await launch();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
});

for (const { scene, t, view = "layers=skin,objects,shadows,ground" } of MOMENTS) {
  test(scene, async () => {
    const hash = `?quality=high#scene=${scene}&t=${t}&${view}&ui=off`;
    const { page, problems } = await open(browser, server.url, { hash, width: FINER * WIDTH, height: FINER * HEIGHT, pixelRatio: 1 });
    await expect
      .poll(() => page.evaluate(() => document.documentElement.dataset["moment"]), { timeout: 240_000 })
      .toBe("reached");
    // The stage shows the last snapshot a moment later.
    await page.waitForTimeout(1000);
    const base64 = await page.evaluate(
      async ([width, height, finer]) => {
        const blob = await window.thenar.app.stage.screenshot(finer * width, finer * height);
        const options = { resizeWidth: width, resizeHeight: height, resizeQuality: "high" } as const;
        const canvas = new OffscreenCanvas(width, height);
        canvas.getContext("2d")!.drawImage(await createImageBitmap(blob, options), 0, 0);
        const webp = await canvas.convertToBlob({ type: "image/webp", quality: 0.85 });
        return btoa(String.fromCharCode(...new Uint8Array(await webp.arrayBuffer())));
      },
      [WIDTH, HEIGHT, FINER] as const,
    );
    writeFileSync(`${folder}${scene}.webp`, Buffer.from(base64, "base64"));
    expect(histogram(await picture(page)).black).toBeLessThan(0.5);
    expect(problems).toEqual([]);
    await page.close();
  });
}
