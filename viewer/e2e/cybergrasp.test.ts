// The paper's Fig. 1, right: a hand wears a CyberGrasp, and the page draws its tendons.

import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import { launch, open, until } from "./support/browser";
import { Server } from "./support/server";

let server: Server;
let browser: Browser;

beforeAll(async () => {
  const light = ["--set", "hand.0.tets=600"];
  server = await Server.start("table-press", ["--device", "simulated:cybergrasp", ...light]);
  browser = await launch();
});

afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
});

const card = (page: Page) => page.getByRole("region", { name: "Devices" });

/** Radius of each tendon that is drawn, thumb first, mm; none while nothing is drawn. */
async function tendons(page: Page): Promise<number[]> {
  return page.evaluate(() => {
    const radii: number[] = [];
    // Tendons alone are cylinders of radius one, scaled; the first segment of each stands for it.
    const seen = new Set<unknown>();
    window.thenar.app.stage.world.traverseVisible((part) => {
      const { geometry, material, scale } = part as unknown as {
        geometry?: { parameters?: { radiusTop?: number } };
        material?: unknown;
        scale: { x: number };
      };
      if (geometry?.parameters?.radiusTop !== 1 || seen.has(material)) return;
      seen.add(material);
      radii.push(1000 * scale.x);
    });
    return radii;
  });
}

test("five slack tendons are drawn on the hand that wears them", { timeout: 240_000 }, async () => {
  const { page, problems } = await open(browser, server.url, { width: 800, height: 620, hash: "?quality=low" });
  await until(page, (t) => t.inControl);
  await card(page).waitFor();
  await expect.poll(() => tendons(page), { timeout: 60_000 }).toHaveLength(5);
  const slack = await tendons(page);
  expect(Math.max(...slack) - Math.min(...slack)).toBeLessThan(1e-6);
  expect(slack[0]).toBeCloseTo(0.7, 6);
  expect(problems).toEqual([]);
});
