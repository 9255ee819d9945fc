// Takes the pictures of docs/gallery.md from the real page, and writes that page.

import { mkdirSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { Browser } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { launch, open } from "./support/browser";
import { FIGURES, address, gallery } from "./support/figures";
import { histogram, picture } from "./support/pixels";
import { Server } from "./support/server";

const docs = fileURLToPath(new URL("../../docs/", import.meta.url));

let server: Server;
let browser: Browser;

beforeAll(async () => {
  mkdirSync(`${docs}images/gallery`, { recursive: true });
  writeFileSync(`${docs}gallery.md`, gallery());
  server = await Server.start("free-motion");
  browser = await launch();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
});

for (const figure of FIGURES) {
  test(`${figure.name}: ${figure.text}`, async () => {
    const hash = `?quality=high${address(figure)}&ui=off`;
    const { page, problems } = await open(browser, server.url, { hash, width: 960, height: 600, pixelRatio: 1 });
    await expect
      .poll(() => page.evaluate(() => document.documentElement.dataset["moment"]), { timeout: 240_000 })
      .toBe("reached");
    // The stage shows the last snapshot a moment later.
    await page.waitForTimeout(2000);
    await page.screenshot({ path: `${docs}images/gallery/${figure.file}`, type: "jpeg", quality: 88 });
    expect(histogram(await picture(page)).black).toBeLessThan(0.5);
    expect(problems).toEqual([]);
    await page.close();
  });
}
