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
  const { width = 1280, height = 720, hash = "", tolerate } = options;
  const page = await browser.newPage({ viewport: { width, height } });
  const problems: string[] = [];
  const note = (text: string): void => {
    if (tolerate === undefined || !tolerate.test(text)) problems.push(text);
  };
  page.on("pageerror", (error) => note(`${error.message}\n${error.stack ?? ""}`));
  page.on("console", (message) => {
    if (message.type() === "error") note(message.text());
  });
  await page.goto(`${url}${hash}`);
  await page.waitForFunction(() => window.thenar?.snapshot != null && window.thenar.framesDrawn > 2, null, {
    timeout: 60_000,
  });
  return { page, problems };
}

/** Reads from `window.thenar`. */
export async function read<T>(page: Page, pick: (thenar: PageStatus) => T): Promise<T> {
  return page.evaluate(`(${pick.toString()})(window.thenar)`) as Promise<T>;
}

/** Waits until something is true of `window.thenar`. */
export async function until(page: Page, test: (thenar: PageStatus) => boolean, seconds = 30): Promise<void> {
  await page.waitForFunction(`(${test.toString()})(window.thenar)`, null, { timeout: seconds * 1000 });
}
