// The browser tests' server leaves nothing behind, wherever the tests are started.

import { existsSync, mkdtempSync, readFileSync, readdirSync, realpathSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterEach, beforeEach, expect, it } from "vitest";
import { Server } from "../../e2e/support/server";

/** A program that answers as `thenar serve` does, tells where it works, and litters the place. */
const FAKE = `#!/usr/bin/env node
const { writeFileSync } = require("node:fs");
writeFileSync("thenar-trip-1.csv", "# forces stopped");
process.stdout.write("in " + process.cwd() + "\\n");
const port = Number(process.argv[process.argv.indexOf("--port") + 1]);
process.on("SIGINT", () => process.exit(0));
require("node:http").createServer((_, answer) => answer.setHeader("x-program", "fake").end("page")).listen(port, "127.0.0.1");
`;

let folder: string;
let before: string | undefined;

beforeEach(() => {
  folder = realpathSync(mkdtempSync(join(tmpdir(), "thenar-fake-")));
  writeFileSync(join(folder, "thenar"), FAKE, { mode: 0o755 });
  before = process.env["THENAR_BIN"];
  process.env["THENAR_BIN"] = join(folder, "thenar");
});

afterEach(() => {
  if (before === undefined) delete process.env["THENAR_BIN"];
  else process.env["THENAR_BIN"] = before;
  rmSync(folder, { recursive: true });
});

const places = (server: Server) => [...server.output.matchAll(/^in (.*)$/gm)].map((found) => found[1]!);

it("works in a folder of its own, which goes with it", async () => {
  const here = readdirSync(".");
  const server = await Server.start("fist");
  const [place] = places(server);
  expect(readFileSync(join(place!, "thenar-trip-1.csv"), "utf8")).toContain("forces stopped");
  expect(await server.stop()).toBe(0);
  expect(existsSync(place!)).toBe(false);
  expect(readdirSync(".")).toEqual(here);
});

it("shows the page of a folder in the program's place, behind the program's headers", async () => {
  writeFileSync(join(folder, "index.html"), "a new page");
  process.env["THENAR_PAGE"] = folder;
  const server = await Server.start("fist").finally(() => delete process.env["THENAR_PAGE"]);
  const answer = await fetch(server.url);
  expect([await answer.text(), answer.headers.get("x-program")]).toEqual(["a new page", "fake"]);
  expect((await fetch(`${server.url}absent.js`)).status).toBe(404);
  expect((await fetch(`${server.url}..%2f..%2fetc%2fpasswd`)).status).toBe(404);
  await server.stop();
});

it("takes a new folder after a crash, and ends twice without harm", async () => {
  const server = await Server.start("fist");
  await server.kill();
  await server.restart();
  const [first, second] = places(server);
  expect(second).not.toBe(first);
  await server.stop();
  expect(await server.stop()).toBeNull();
  expect([existsSync(first!), existsSync(second!)]).toEqual([false, false]);
});
