// The connection with a socket that does as it is told: it reconnects by itself, forgets the old
// server's model, and turns bad messages into one complaint.

import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Connection } from "../src/net/connection";
import { Clock, Latency } from "../src/net/measure";
import { encodeSnapshot, encodeWorld } from "./encode-world";

class FakeSocket {
  static readonly OPEN = 1;
  static readonly all: FakeSocket[] = [];
  binaryType = "";
  readyState = 0;
  bufferedAmount = 0;
  readonly sent: (string | ArrayBuffer)[] = [];
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: string | ArrayBuffer }) => void) | null = null;
  onclose: (() => void) | null = null;

  constructor(readonly url: string) {
    FakeSocket.all.push(this);
  }

  open(): void {
    this.readyState = 1;
    this.onopen?.();
  }

  send(data: string | ArrayBuffer): void {
    this.sent.push(data);
  }

  close(): void {
    this.readyState = 3;
    this.onclose?.();
  }
}

const newest = () => FakeSocket.all[FakeSocket.all.length - 1];

beforeEach(() => {
  vi.useFakeTimers();
  FakeSocket.all.length = 0;
  vi.stubGlobal("WebSocket", FakeSocket);
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe("a connection", () => {
  it("comes back when the server does, and starts afresh", () => {
    const connection = new Connection("ws://here/live");
    const opened: boolean[] = [];
    const waits: (number | null)[] = [];
    connection.on("open", ({ again }) => opened.push(again));
    connection.on("close", ({ retryIn }) => waits.push(retryIn));
    connection.connect();
    newest().open();
    newest().onmessage?.({ data: encodeWorld(4) });
    newest().onmessage?.({ data: encodeSnapshot(4, 0) });
    expect([connection.model?.epoch, connection.snapshotsReceived]).toEqual([4, 1]);

    newest().close();
    expect([connection.state, connection.model]).toEqual(["waiting", null]);
    // Nobody is there for five tries; pauses grow, up to five seconds and a quarter.
    for (let attempt = 0; attempt < 5; attempt++) {
      vi.advanceTimersByTime(6300);
      newest().close();
    }
    const pauses = waits.map((wait) => wait ?? 0);
    pauses.forEach((pause, i) => {
      const nominal = Math.min(5, 0.25 * 2 ** i);
      expect(pause).toBeGreaterThanOrEqual(0.75 * nominal);
      expect(pause).toBeLessThanOrEqual(1.25 * nominal);
    });
    vi.advanceTimersByTime(6300);
    newest().open();
    // A new server counts its models from one again.
    newest().onmessage?.({ data: encodeSnapshot(1, 0) });
    expect(connection.snapshotsReceived).toBe(1);
    newest().onmessage?.({ data: encodeWorld(1) });
    newest().onmessage?.({ data: encodeSnapshot(1, 0) });
    expect([connection.model?.epoch, connection.snapshotsReceived]).toEqual([1, 2]);
    expect(opened).toEqual([false, true]);
    connection.close();
    expect(vi.getTimerCount()).toBe(0);
  });

  it("takes a line on which nothing comes for dead", () => {
    const connection = new Connection("ws://here/live");
    connection.connect();
    newest().open();
    vi.advanceTimersByTime(7000);
    expect(connection.state).toBe("open");
    vi.advanceTimersByTime(4000);
    expect(FakeSocket.all.length).toBeGreaterThan(1);
  });

  it("complains once a second about what it cannot read, and goes on", () => {
    const connection = new Connection("ws://here/live");
    const errors: string[] = [];
    connection.on("error", ({ message }) => errors.push(message));
    connection.connect();
    newest().open();
    for (let i = 0; i < 50; i++) newest().onmessage?.({ data: new ArrayBuffer(3) });
    expect(errors).toEqual(["A message of 3 bytes has no header."]);
    newest().onmessage?.({ data: encodeWorld(2) });
    expect(connection.model?.epoch).toBe(2);
    connection.close();
  });

  it("numbers poses from one and drops them on a line that is jammed", () => {
    const connection = new Connection("ws://here/live");
    expect(connection.sendLost("left")).toBe(0);
    connection.connect();
    newest().open();
    expect([connection.sendLost("left"), connection.sendLost("right")]).toEqual([1, 2]);
    newest().bufferedAmount = 100_000;
    expect(connection.sendLost("right")).toBe(0);
    connection.close();
  });
});

describe("measurements", () => {
  it("take the clock's offset from the quickest answer", () => {
    const clock = new Clock();
    clock.pong(10, 110.3, 10.4);
    clock.pong(12, 112.01, 12.02);
    clock.pong(14, 114.9, 14.9);
    expect(clock.offset).toBeCloseTo(100, 9);
    expect(clock.roundTrip).toBeCloseTo(0.02, 9);
  });

  it("count a pose's latency once, at the first snapshot it acted in", () => {
    const latency = new Latency();
    latency.sent(1, 100);
    latency.sent(2, 104);
    latency.acted(2, 110);
    latency.acted(2, 116);
    expect(latency.median).toBe(6);
  });
});
