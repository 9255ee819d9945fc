// The server dies and comes back; the page says so and goes on by itself.

import type { Browser } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { launch, open, read, until } from "./support/browser";
import { Server } from "./support/server";

let server: Server;
let browser: Browser;

beforeAll(async () => {
  server = await Server.start("table-press");
  browser = await launch();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
});

test("the server is killed and comes back and the page recovers", async () => {
  const { page, problems } = await open(browser, server.url, { tolerate: /WebSocket|ERR_CONNECTION/ });
  await server.kill();
  await until(page, (t) => t.connection === "waiting" || t.connection === "connecting");
  await page.getByText(/server/i).filter({ visible: true }).first().waitFor();
  const received = await read(page, (t) => t.snapshotsReceived);
  await server.restart();
  await until(page, (t) => t.connection === "open");
  await page.waitForFunction((n) => window.thenar.snapshotsReceived > n + 10, received);
  await until(page, (t) => t.inControl);
  const drawn = await read(page, (t) => t.framesDrawn);
  await page.waitForFunction((n) => window.thenar.framesDrawn > n + 3, drawn);
  expect(problems).toEqual([]);
  await page.close();
});
