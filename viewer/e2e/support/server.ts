// Runs `thenar serve` as a user would, and stops it as a user would. Each run works in a folder of its own, which goes with
// it: what the program writes beside itself, such as the last seconds before forces stop, litters nothing.

import { spawn, type ChildProcess } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import type { Server as Front } from "node:http";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { front } from "./front";

const PROGRAMS = ["../../../target/release/thenar", "../../../target/debug/thenar"];

/** The program: `THENAR_BIN`, or the newest build of this checkout. */
export function program(): string {
  const given = process.env["THENAR_BIN"];
  if (given !== undefined) return resolve(given);
  const built = PROGRAMS.map((path) => fileURLToPath(new URL(path, import.meta.url))).find(existsSync);
  if (built === undefined) throw new Error("No thenar program: run `cargo build --release`, or set THENAR_BIN.");
  return built;
}

/** A port that nobody listens on. */
export async function freePort(): Promise<number> {
  return new Promise((resolve, reject) => {
    const probe = createServer();
    probe.once("error", reject);
    probe.listen(0, "127.0.0.1", () => {
      const address = probe.address();
      if (address === null || typeof address === "string") return reject(new Error("no port"));
      probe.close(() => resolve(address.port));
    });
  });
}

export class Server {
  /** What it printed, both streams. */
  output = "";
  private child: ChildProcess | null = null;
  private front: Front | null = null;
  /** Where the program works; null while none runs. */
  private folder: string | null = null;

  private constructor(
    /** Where browsers look: the program's own port, or that of the folder before it. */
    private readonly shown: number,
    private readonly args: readonly string[],
  ) {}

  static async start(scene: string, args: readonly string[] = []): Promise<Server> {
    return Server.of(["serve", scene, ...args]);
  }

  /** Shows a recording. */
  static async replay(file: string): Promise<Server> {
    return Server.of(["replay", resolve(file), "--serve"]);
  }

  private static async of(args: readonly string[]): Promise<Server> {
    const port = await freePort();
    const folder = process.env["THENAR_PAGE"];
    const shown = folder === undefined ? port : await freePort();
    const server = new Server(shown, [...args, "--port", String(port), "--no-open"]);
    if (folder !== undefined) server.front = await front(resolve(folder), shown, port);
    await server.restart();
    return server;
  }

  get url(): string {
    return `http://127.0.0.1:${this.shown}/`;
  }

  /** Starts the program again on the same port. */
  async restart(): Promise<void> {
    const cwd = mkdtempSync(join(tmpdir(), "thenar-e2e-"));
    const child = spawn(program(), this.args, { cwd, stdio: ["ignore", "pipe", "pipe"] });
    this.child = child;
    this.folder = cwd;
    for (const stream of [child.stdout, child.stderr]) {
      stream.on("data", (data: Buffer) => (this.output += data.toString()));
    }
    for (let tries = 0; tries < 300; tries++) {
      if (child.exitCode !== null) break;
      try {
        const answer = await fetch(this.url);
        if (answer.ok) return;
      } catch {
        // Not listening yet.
      }
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
    throw new Error(`The server did not come up:\n${this.output}`);
  }

  /** Ends it at once, as a crash would. */
  async kill(): Promise<void> {
    await this.end("SIGKILL");
  }

  /** Ends it with Ctrl-C; gives its exit code. */
  async stop(): Promise<number | null> {
    this.front?.close();
    return this.end("SIGINT");
  }

  private async end(signal: NodeJS.Signals): Promise<number | null> {
    const { child, folder } = this;
    this.child = null;
    this.folder = null;
    if (child !== null && child.exitCode === null && child.signalCode === null) {
      const ended = new Promise((done) => child.once("exit", done));
      child.kill(signal);
      await ended;
    }
    if (folder !== null) rmSync(folder, { recursive: true });
    return child?.exitCode ?? null;
  }
}
