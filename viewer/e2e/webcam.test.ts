// A camera that shows a hand, in a real browser: another thread finds it, and the simulated hand follows.

import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import type { Browser } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { grows, launch, open, read, until } from "./support/browser";
import { Server } from "./support/server";

/** An open right hand, as our own page draws it. */
const HAND = fileURLToPath(new URL("../../docs/images/gallery/fig-2-middle.jpg", import.meta.url));

const folder = mkdtempSync(join(tmpdir(), "thenar-camera-"));
let server: Server;
let browser: Browser;

beforeAll(async () => {
  // Motion JPEG is one picture after the other.
  const film = join(folder, "hand.mjpeg");
  writeFileSync(film, Buffer.concat(Array<Buffer>(4).fill(readFileSync(HAND))));
  const camera = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"];
  server = await Server.start("free-motion", ["--set", "hand.0.tets=600"]);
  browser = await launch([...camera, `--use-file-for-fake-video-capture=${film}`]);
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
  rmSync(folder, { recursive: true });
});

test("a hand before the camera is found off the page's thread, and followed", { timeout: 240_000 }, async () => {
  // MediaPipe says so as an error, and means none.
  const tolerate = /^INFO: Created TensorFlow Lite XNNPACK delegate/;
  const { page, problems } = await open(browser, server.url, { width: 800, height: 620, hash: "?quality=low", tolerate });
  await until(page, (t) => t.inControl);
  expect(page.workers().length).toBe(0);
  await page.evaluate(() => window.thenar.app.inputs.start("webcam"));
  expect(page.workers().map((worker) => /hand-worker/.test(worker.url()))).toEqual([true]);
  await until(page, (t) => t.tracking!.webcam.note.startsWith("Tracking: right hand."), 120);
  await until(page, (t) => (t.snapshot!.flags & 32) !== 0, 60);
  expect(await read(page, (t) => t.app.inputs.active!.led())).toEqual(["right"]);
  // The picture goes on while others are looked at.
  await grows(page, (t) => t.tracking!.webcam.pictures, 3);
  await grows(page, (t) => t.framesDrawn, 3);

  // Once stopped and started again the same thread goes on.
  await page.evaluate(() => window.thenar.app.inputs.stop());
  await until(page, (t) => (t.snapshot!.flags & 32) === 0);
  await page.evaluate(() => window.thenar.app.inputs.start("webcam"));
  await until(page, (t) => t.tracking!.webcam.note.startsWith("Tracking: right hand."), 60);
  expect(page.workers().length).toBe(1);
  expect(problems).toEqual([]);
});
