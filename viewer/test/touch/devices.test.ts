// What the page makes of reports on devices: what it shows, when it says that it is still there, and
// how a stop gets through. Time and line are the test's.

import { beforeEach, describe, expect, it } from "vitest";
import type { Command, Touch } from "../../src/protocol/types";
import { deviceText, loopText } from "../../src/touch/card";
import { Devices } from "../../src/touch/devices";
import { columns, share } from "../../src/touch/fingers";

const ME = 4;

const HAND: Touch["hands"][number] = {
  side: "right",
  tracked: true,
  renders: "tendons",
  force_max: 5,
  wanted: [0, 3, 0, 0, 0],
  sent: [0, 2, 0, 0, 0],
};

function report(more: Partial<Touch> = {}): Touch {
  return {
    type: "touch",
    state: "dry-run",
    reason: null,
    armed_by: null,
    rate: 1000,
    ticks: 0,
    missed: 0,
    period_p999_us: 1180,
    devices: [],
    hands: [HAND],
    warnings: [],
    messages: [],
    statement: "Research use only.",
    ...more,
  };
}

let sent: Command[];
let up: boolean;
let devices: Devices;

beforeEach(() => {
  sent = [];
  up = true;
  const send = (command: Command) => {
    if (up) sent.push(command);
    return up;
  };
  devices = new Devices({ send, me: () => (up ? ME : null) });
  devices.opened(0);
});

const types = () => sent.map(({ type }) => type);

describe("what is shown", () => {
  it.each([
    [report(), "safe", "Dry run", /^No force goes out/],
    [report({ state: "waiting" }), "armed", "ARMED", /^No force yet/],
    [
      report({ state: "waiting", reason: "no tracked pose for 0.2 s" }),
      "armed",
      "ARMED",
      /No tracked pose for 0.2 s\.$/,
    ],
    [report({ state: "ramping" }), "armed", "ARMED", /grows/],
    [report({ state: "live" }), "armed", "ARMED", /^Full force/],
    [
      report({ state: "tripped", reason: "stop was asked for" }),
      "stopped",
      "Stopped",
      /Stop was asked for\.$/,
    ],
    [report({ state: "failed" }), "stopped", "Failed", /Start the program again/],
  ] as const)("%#: level, headline and reason follow the state", (touch, level, headline, reason) => {
    devices.reported(touch, 100);
    expect(devices.level(100)).toBe(level);
    expect(devices.headline(100)).toBe(headline);
    expect(devices.reason(100)).toMatch(reason);
  });

  it("is nothing before the first report: there may be no devices", () => {
    expect([devices.level(1e6), devices.reason(1e6), devices.deadlines()]).toEqual(["safe", "", null]);
  });

  it("is not known when reports stop coming, and never passes for safe", () => {
    devices.reported(report({ state: "live" }), 0);
    expect(devices.level(1500)).toBe("armed");
    expect([devices.level(1501), devices.headline(1501)]).toEqual(["unknown", "Not known"]);
    expect(devices.reason(1501)).toMatch(/Forces may still be on/);
    devices.reported(report({ state: "live" }), 1600);
    expect(devices.level(1600)).toBe("armed");
  });

  it("says what ends the forces: this page, another, or nobody", () => {
    for (const [armed_by, text] of [
      [ME, /this page is closed/],
      [9, /^Viewer 9 armed/],
      [null, /^Armed until somebody stops/],
    ] as const) {
      devices.reported(report({ state: "live", armed_by }), 0);
      expect(devices.keeper(0)).toMatch(text);
    }
    devices.reported(report({ state: "tripped", reason: "stop was asked for", armed_by: ME }), 0);
    expect(devices.keeper(0)).toBe("");
  });

  it("counts the deadlines of the last ten seconds only, and anew after a restart", () => {
    const tick = (s: number, missed: number) =>
      devices.reported(report({ ticks: 1000 * s, missed }), 1000 * s);
    tick(0, 500);
    for (let s = 1; s <= 30; s++) tick(s, 500 + (s > 25 ? 10 : 0));
    expect(devices.deadlines()).toEqual({ missed: 10, of: 10_010 });
    expect(loopText(report(), devices)).toEqual({
      text: "1000 Hz, 99.9 % of periods within 1.18 ms, 10 of the last 10010 deadlines missed",
      late: false,
    });
    tick(31, 600);
    expect(loopText(report(), devices).late).toBe(true);
    // The program was started again: its counts begin anew.
    devices.reported(report({ ticks: 5, missed: 0 }), 32_000);
    expect(devices.deadlines()).toBeNull();
  });
});

describe("a page that armed", () => {
  it("answers each report that it is still there, and no report that others armed", () => {
    devices.arm(false, 0);
    devices.reported(report({ state: "waiting", armed_by: ME }), 250);
    devices.reported(report({ state: "live", armed_by: ME }), 500);
    devices.reported(report({ state: "live", armed_by: 9 }), 750);
    devices.reported(report({ state: "live" }), 1000);
    expect(sent).toEqual([{ type: "arm" }, { type: "hold" }, { type: "hold" }]);
  });

  it("says that it is arming until that shows, or has had its time", () => {
    devices.reported(report(), 0);
    devices.arm(false, 100);
    // This report was on its way already.
    devices.reported(report(), 250);
    expect(devices.headline(250)).toBe("Arming…");
    devices.reported(report({ state: "waiting", armed_by: ME }), 500);
    expect(devices.headline(500)).toBe("ARMED");
    devices.reported(report({ state: "tripped" }), 750);
    expect(devices.headline(750)).toBe("Stopped");
    // Refused: nothing comes of it.
    devices.arm(false, 1000);
    devices.reported(report(), 2000);
    expect([devices.headline(2000), devices.headline(2500)]).toEqual(["Arming…", "Dry run"]);
    devices.arm(false, 3000);
    devices.reported(report(), 3000);
    devices.stop(3100);
    expect(devices.headline(3100)).toBe("Dry run");
  });

  it("asks for forces that outlast it only when told to", () => {
    devices.arm(true, 0);
    expect(sent).toEqual([{ type: "arm", keep: true }]);
  });

  it("tells after a loss of the line that forces end by themselves", () => {
    devices.reported(report({ state: "live", armed_by: ME }), 0);
    devices.closed();
    expect(devices.level(1)).toBe("unknown");
    expect(devices.reason(1)).toMatch(/connection is lost.*end by themselves within three seconds/);
  });
});

describe("a stop", () => {
  it("goes out at once, shows, and is over when the report says so", () => {
    devices.reported(report({ state: "live", armed_by: ME }), 0);
    devices.stop(10);
    expect([types(), devices.headline(10)]).toEqual([["hold", "stop"], "Stopping…"]);
    devices.reported(report({ state: "tripped", reason: "stop was asked for" }), 250);
    expect([devices.stopping, devices.headline(250)]).toEqual([false, "Stopped"]);
  });

  it("is sent again while devices are still armed, and the page holds nothing meanwhile", () => {
    devices.reported(report({ state: "live", armed_by: ME }), 0);
    sent.length = 0;
    devices.stop(10);
    // This report was on its way already.
    devices.reported(report({ state: "live", armed_by: ME }), 250);
    expect(types()).toEqual(["stop"]);
    devices.reported(report({ state: "live", armed_by: ME }), 520);
    expect(types()).toEqual(["stop", "stop"]);
  });

  it("that finds no line goes out before anything else when there is one again", () => {
    devices.reported(report({ state: "live", armed_by: 9 }), 0);
    up = false;
    devices.closed();
    devices.stop(100);
    expect(sent).toEqual([]);
    expect(devices.reason(100)).toMatch(/Stop goes out as soon as the connection is back/);
    up = true;
    devices.opened(5000);
    expect(types()).toEqual(["stop"]);
  });

  it("is nothing where there are no devices", () => {
    devices.stop(0);
    expect(sent).toEqual([]);
  });

  it("of before does not undo a new arming", () => {
    devices.reported(report({ state: "live" }), 0);
    devices.stop(10);
    devices.reported(report({ state: "tripped" }), 250);
    devices.arm(false, 1000);
    devices.reported(report({ state: "waiting", armed_by: ME }), 2000);
    expect(types()).toEqual(["stop", "arm", "hold"]);
  });
});

describe("fingers and devices", () => {
  it("name five fingers, or the axes of a device that holds one point", () => {
    expect(columns(HAND).map(({ label, wanted, sent }) => [label, wanted, sent])).toEqual([
      ["Thumb", 0, 0],
      ["Index", 3, 2],
      ["Middle", 0, 0],
      ["Ring", 0, 0],
      ["Little", 0, 0],
    ]);
    expect(columns({ ...HAND, renders: "wrench" }).map(({ label }) => label)).toEqual(["x", "y", "z"]);
  });

  it("fill a bar by the force allowed, whatever its sign, and no further", () => {
    expect([share(2, 5), share(-2, 5), share(9, 5), share(1, 0)]).toEqual([0.4, 0.4, 1, 0]);
  });

  it("tell a device that is there from one that is silent or away", () => {
    const device = { name: "glove", connected: true, silent_s: 0.01, tracks: true, shows: true };
    expect(deviceText(device)).toBe("connected · tracks, shows force");
    expect(deviceText({ ...device, silent_s: 3.2, shows: false })).toBe("silent for 3 s · tracks");
    expect(deviceText({ ...device, silent_s: null, tracks: false })).toBe("silent so far · shows force");
    expect(deviceText({ ...device, connected: false })).toBe("not connected · tracks, shows force");
  });
});
