// The socket to the server. It reconnects by itself, with growing pauses, for as long as the page
// is open; a bad message becomes an error event and nothing else.

import { decode } from "../protocol/decode";
import { encodeAngles, encodeJoints, encodeLost } from "../protocol/poses";
import { decodeText } from "../protocol/text";
import type { Command, SceneModel, Side, Snapshot, Status, Touch, Welcome } from "../protocol/types";
import { Emitter } from "./events";
import { Clock, Latency, Throughput } from "./measure";

export type ConnectionState = "connecting" | "open" | "waiting" | "closed";

export interface ConnectionEvents {
  open: { readonly again: boolean };
  /** Lost, or not reached; the next try comes in `retryIn` seconds (null: none). */
  close: { readonly retryIn: number | null; readonly attempts: number };
  welcome: Welcome;
  status: Status;
  touch: Touch;
  model: SceneModel;
  snapshot: Snapshot;
  /** A model or snapshot as it came, after its own event; for recording. */
  binary: ArrayBuffer;
  /** What the server refused, or what it sent that cannot be read. */
  error: { readonly message: string; readonly from: "server" | "page" };
}

const RETRY_FIRST = 0.25;
const RETRY_MOST = 5;
const PING_EVERY = 2;
/** With the server's answers missing for this long, the line is taken for dead, s. */
const SILENCE_MOST = 8;
/** Poses wait no longer than this many bytes in the browser; a late pose is worth nothing. */
const POSE_BACKLOG = 16384;

export class Connection extends Emitter<ConnectionEvents> {
  state: ConnectionState = "closed";
  welcome: Welcome | null = null;
  status: Status | null = null;
  model: SceneModel | null = null;
  /** The message the model came in. */
  modelBytes: ArrayBuffer | null = null;
  snapshot: Snapshot | null = null;
  snapshotsReceived = 0;
  readonly clock = new Clock();
  readonly latency = new Latency();
  readonly throughput = new Throughput();

  private socket: WebSocket | null = null;
  private attempts = 0;
  private retryTimer: ReturnType<typeof setTimeout> | undefined;
  private pingTimer: ReturnType<typeof setInterval> | undefined;
  private lastHeard = 0;
  private poseNumber = 0;
  private lastError = { message: "", at: -Infinity };

  constructor(private readonly url: string) {
    super();
  }

  /** True while this client holds control. */
  get inControl(): boolean {
    return (
      this.state === "open" &&
      this.welcome !== null &&
      this.status !== null &&
      this.status.control === this.welcome.client
    );
  }

  connect(): void {
    clearTimeout(this.retryTimer);
    if (this.socket !== null) return;
    this.state = "connecting";
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => this.opened();
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (this.socket === socket) this.received(event.data);
    };
    socket.onclose = () => {
      if (this.socket === socket) this.lost();
    };
  }

  /** Closes for good. */
  close(): void {
    clearTimeout(this.retryTimer);
    const socket = this.socket;
    this.forget();
    this.state = "closed";
    socket?.close();
    this.emit("close", { retryIn: null, attempts: this.attempts });
  }

  /** Sends a command; false if there is no connection. */
  send(command: Command): boolean {
    if (this.socket === null || this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(command));
    return true;
  }

  /** 25 joints × 8 numbers in the world frame. The message's number, or 0 if it was not sent. */
  sendJoints(side: Side, joints: ArrayLike<number>): number {
    return this.sendPose((number, clock) => encodeJoints(side, number, clock, joints));
  }

  /** Wrist pose (7) in the world frame and 20 angles. */
  sendAngles(side: Side, wrist: ArrayLike<number>, angles: ArrayLike<number>): number {
    return this.sendPose((number, clock) => encodeAngles(side, number, clock, wrist, angles));
  }

  sendLost(side: Side): number {
    return this.sendPose((number, clock) => encodeLost(side, number, clock));
  }

  private sendPose(encode: (number: number, clock: number) => ArrayBuffer): number {
    const socket = this.socket;
    if (socket === null || socket.readyState !== WebSocket.OPEN) return 0;
    if (socket.bufferedAmount > POSE_BACKLOG) return 0;
    const now = performance.now();
    this.poseNumber += 1;
    socket.send(encode(this.poseNumber, now / 1000));
    this.latency.sent(this.poseNumber, now);
    return this.poseNumber;
  }

  private opened(): void {
    const again = this.attempts > 0 || this.welcome !== null;
    this.attempts = 0;
    this.poseNumber = 0;
    this.state = "open";
    this.lastHeard = performance.now();
    this.clock.reset();
    this.latency.reset();
    this.ping();
    this.pingTimer = setInterval(() => this.ping(), PING_EVERY * 1000);
    this.emit("open", { again });
  }

  private ping(): void {
    const now = performance.now();
    if (now - this.lastHeard > SILENCE_MOST * 1000) {
      this.socket?.close();
      this.lost();
      return;
    }
    this.send({ type: "ping", t: now / 1000 });
  }

  private received(data: string | ArrayBuffer): void {
    const now = performance.now();
    this.lastHeard = now;
    try {
      if (typeof data === "string") this.receivedText(data, now);
      else this.receivedBytes(data, now);
    } catch (error) {
      this.complain(error instanceof Error ? error.message : String(error), now);
    }
  }

  private receivedBytes(data: ArrayBuffer, now: number): void {
    this.throughput.add(data.byteLength, now);
    const message = decode(data, this.model, now);
    if (message.kind === "model") {
      this.model = message.model;
      this.snapshot = null;
      this.modelBytes = data;
      this.emit("model", message.model);
    } else if (message.kind === "snapshot") {
      this.snapshot = message.snapshot;
      this.snapshotsReceived += 1;
      this.latency.acted(message.snapshot.poseNumber, now);
      this.emit("snapshot", message.snapshot);
    }
    if (message.kind !== "stale") this.emit("binary", data);
  }

  private receivedText(data: string, now: number): void {
    this.throughput.add(data.length, now);
    const message = decodeText(data);
    switch (message?.type) {
      case "welcome":
        this.welcome = message;
        this.emit("welcome", message);
        break;
      case "status":
        this.status = message;
        this.emit("status", message);
        break;
      case "touch":
        this.emit("touch", message);
        break;
      case "error":
        this.emit("error", { message: message.message, from: "server" });
        break;
      case "pong":
        this.clock.pong(message.t, message.server, now / 1000);
        break;
    }
  }

  /** The same complaint is made once a second at most. */
  private complain(message: string, now: number): void {
    if (message === this.lastError.message && now - this.lastError.at < 1000) return;
    this.lastError = { message, at: now };
    this.emit("error", { message, from: "page" });
  }

  private lost(): void {
    this.forget();
    this.attempts += 1;
    this.state = "waiting";
    const pause = Math.min(RETRY_MOST, RETRY_FIRST * 2 ** (this.attempts - 1));
    // Pages that lost the same server should not all come back in the same instant.
    const retryIn = pause * (0.75 + 0.5 * Math.random());
    this.retryTimer = setTimeout(() => this.connect(), retryIn * 1000);
    this.emit("close", { retryIn, attempts: this.attempts });
  }

  private forget(): void {
    clearInterval(this.pingTimer);
    if (this.socket !== null) {
      this.socket.onopen = null;
      this.socket.onmessage = null;
      this.socket.onclose = null;
    }
    this.socket = null;
    // What comes next may be another server: its epochs start anew.
    this.model = null;
    this.modelBytes = null;
    this.snapshot = null;
    this.status = null;
  }
}

/** The socket's address for a page at `location`, with its pairing token if the page has one. */
export function socketUrl(location: Location): string {
  const url = new URL("live", location.href);
  url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  url.hash = "";
  const token = new URLSearchParams(location.search).get("token");
  url.search = token === null ? "" : `?token=${encodeURIComponent(token)}`;
  return url.href;
}
