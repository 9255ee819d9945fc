// Who has the hand: one source at a time, and the script when none.

import { describe, expect, it } from "vitest";
import { InputSourceBase, InputSources } from "../src/input/source";

class Fake extends InputSourceBase {
  readonly label = "Fake";
  readonly help = "";
  constructor(
    readonly id: string,
    private readonly log: string[],
    private readonly failure: string | null = null,
  ) {
    super();
  }

  start(): void {
    if (this.failure !== null) throw new Error(this.failure);
    this.log.push(`start ${this.id}`);
    this.set("on");
  }

  stop(): void {
    this.log.push(`stop ${this.id}`);
    this.set("off");
  }

  led(): [] {
    return [];
  }

  unplug(): void {
    this.set("failed", "unplugged");
  }
}

function desk(free = true, recorded = false) {
  const log: string[] = [];
  const script = () => void log.push("script");
  const line = { inControl: free, recorded, askControl: () => free, script };
  return { log, sources: new InputSources(line) };
}

describe("input sources", () => {
  it("hand over from one to the next without the script in between", async () => {
    const { log, sources } = desk();
    sources.register(new Fake("a", log));
    sources.register(new Fake("b", log));
    await sources.start("a");
    await sources.start("b");
    sources.stop();
    expect(log).toEqual(["start a", "stop a", "start b", "stop b", "script"]);
    expect(sources.active).toBeNull();
  });

  it("do not begin where a recording is shown", async () => {
    const { log, sources } = desk(true, true);
    sources.register(new Fake("a", log));
    await expect(sources.start("a")).rejects.toThrow("This is a recording");
    expect([log, sources.active]).toEqual([[], null]);
  });

  it("give the hand back when a source ends by itself", async () => {
    const { log, sources } = desk();
    const source = new Fake("a", log);
    sources.register(source);
    await sources.start("a");
    source.unplug();
    expect(sources.active).toBeNull();
    expect(log).toEqual(["start a", "script"]);
  });

  it("say why a source does not start", async () => {
    const { log, sources } = desk();
    sources.register(new Fake("a", log, "no camera"));
    await expect(sources.start("a")).rejects.toThrow("no camera");
    await expect(sources.start("c")).rejects.toThrow('no input "c"');
    expect(sources.active).toBeNull();
  });

  it("do not start while someone else holds control", async () => {
    const { log, sources } = desk(false);
    sources.register(new Fake("a", log));
    await expect(sources.start("a")).rejects.toThrow("control");
    expect(log).toEqual([]);
  });
});
