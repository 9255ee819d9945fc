// A real Chromium with software rendering, and what tests ask of a page.

import { existsSync } from "node:fs";
import { chromium, type Browser, type Page } from "playwright-core";
import type { PageStatus } from "../../src/app";

const CHROMIUMS = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

const FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];

export async function launch(extra: readonly string[] = []): Promise<Browser> {
  const executablePath = process.env["THENAR_CHROMIUM"] ?? CHROMIUMS.find(existsSync);
  if (executablePath === undefined) {
    throw new Error("No Chromium: install Debian's `chromium`, or set THENAR_CHROMIUM to one.");
  }
  return chromium.launch({ executablePath, headless: true, args: [...FLAGS, ...extra] });
}

export interface OpenOptions {
  readonly width?: number;
  readonly height?: number;
  /** Pixels of the picture per pixel of the layout, a half unless told: software draws half of them in less time. */
  readonly pixelRatio?: number;
  /** After `#`: the view to restore. */
  readonly hash?: string;
  /** Counts errors that the test expects, such as a refused socket while the server is away. */
  readonly tolerate?: RegExp;
}

/** A page, and everything that went wrong in it. */
export interface Opened {
  readonly page: Page;
  readonly problems: string[];
}

/** Opens the page and waits until it has drawn a snapshot. */
export async function open(browser: Browser, url: string, options: OpenOptions = {}): Promise<Opened> {
  const { width = 1280, height = 720, pixelRatio = 0.5, hash = "", tolerate } = options;
  const page = await browser.newPage({ viewport: { width, height }, deviceScaleFactor: pixelRatio });
  const problems: string[] = [];
  const note = (text: string): void => {
    if (tolerate === undefined || !tolerate.test(text)) problems.push(text);
  };
  page.on("pageerror", (error) => note(`${error.message}\n${error.stack ?? ""}`));
  page.on("console", (message) => {
    if (message.type() === "error") note(message.text());
  });
  await page.goto(`${url}${hash}`, { timeout: 60_000 });
  await until(page, (t) => t?.snapshot != null && t.framesDrawn > 2);
  return { page, problems };
}

/** Reads from `window.thenar`. */
export async function read<T>(page: Page, pick: (thenar: PageStatus) => T): Promise<T> {
  return page.evaluate(`(${pick.toString()})(window.thenar)`) as Promise<T>;
}

/** Waits until something is true of `window.thenar`. Asks from here: the page forbids evaluation. */
export async function until(page: Page, test: (thenar: PageStatus) => boolean, seconds = 60): Promise<void> {
  const end = Date.now() + seconds * 1000;
  while (!(await read(page, test))) {
    if (Date.now() > end) throw new Error(`not within ${seconds} s: ${test.toString()}`);
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
}

/** Waits until a count has grown by so much from now on. */
export async function grows(page: Page, pick: (thenar: PageStatus) => number, by: number): Promise<void> {
  const start = await read(page, pick);
  const end = Date.now() + 60_000;
  while ((await read(page, pick)) < start + by) {
    if (Date.now() > end) throw new Error(`did not grow by ${by} within a minute: ${pick.toString()}`);
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
}
