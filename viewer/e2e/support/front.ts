// A page from a folder before a program that has another one inside: `THENAR_PAGE=dist npm run e2e` tries a page that was
// just built with a program of before. Headers are the program's own, so that its content security policy holds here, too.

import { existsSync, readFileSync, statSync } from "node:fs";
import { createServer, type IncomingMessage, type Server } from "node:http";
import { connect } from "node:net";
import { extname, join, normalize } from "node:path";
import type { Duplex } from "node:stream";

const TYPES: Readonly<Record<string, string>> = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".mjs": "text/javascript; charset=utf-8",
  ".css": "text/css; charset=utf-8",
  ".svg": "image/svg+xml",
  ".webp": "image/webp",
  ".wasm": "application/wasm",
};
/** Of one reply, not of the page. */
const ITS_OWN = new Set(["content-type", "content-length", "content-encoding", "etag", "date", "connection", "transfer-encoding", "vary"]);

/** The file that an address names, if the folder has it. */
export function fileOf(folder: string, address: string): string | null {
  const { pathname } = new URL(address, "http://page");
  const path = join(folder, normalize(pathname === "/" ? "/index.html" : pathname));
  return existsSync(path) && statSync(path).isFile() ? path : null;
}

/** Serves `folder` on a port of its own; sockets go on to the program on `port`. */
export async function front(folder: string, listen: number, port: number): Promise<Server> {
  const server = createServer((request, answer) => {
    void (async () => {
      const behind = await fetch(`http://127.0.0.1:${port}/`).catch(() => null);
      const path = fileOf(folder, request.url ?? "/");
      if (behind === null) return answer.writeHead(502).end();
      behind.headers.forEach((value, name) => {
        if (!ITS_OWN.has(name)) answer.setHeader(name, value.replaceAll(`127.0.0.1:${port}`, `127.0.0.1:${listen}`));
      });
      if (path === null) return answer.writeHead(404).end();
      answer.writeHead(200, { "content-type": TYPES[extname(path)] ?? "application/octet-stream" });
      return answer.end(readFileSync(path));
    })();
  });
  server.on("upgrade", (request, socket, head) => passOn(request, socket, head, port));
  await new Promise<void>((done, fail) => {
    server.once("error", fail);
    server.listen(listen, "127.0.0.1", done);
  });
  return server;
}

/** The program takes sockets of its own page only: it sees its own address as host and origin. */
function passOn(request: IncomingMessage, socket: Duplex, head: Buffer, port: number): void {
  const lines = [`${request.method} ${request.url} HTTP/1.1`];
  for (let i = 0; i < request.rawHeaders.length; i += 2) {
    const name = request.rawHeaders[i]!;
    const own: Record<string, string> = { host: `127.0.0.1:${port}`, origin: `http://127.0.0.1:${port}` };
    lines.push(`${name}: ${own[name.toLowerCase()] ?? request.rawHeaders[i + 1]}`);
  }
  const line = connect(port, "127.0.0.1", () => {
    line.write(`${lines.join("\r\n")}\r\n\r\n`);
    line.write(head);
    line.pipe(socket).pipe(line);
  });
  line.on("error", () => socket.destroy());
  line.on("close", () => socket.destroy());
  socket.on("error", () => line.destroy());
  socket.on("close", () => line.destroy());
}
