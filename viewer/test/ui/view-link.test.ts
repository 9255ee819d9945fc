import { describe, expect, it } from "vitest";
import { formatLink, parseLink, type ViewLink } from "../../src/ui/view-link";

const nothing: ViewLink = { scene: null, layers: null, weights: null, camera: null, pauseAt: null, ui: true };

describe("view links", () => {
  it("are read back as written", () => {
    const links: ViewLink[] = [
      nothing,
      { ...nothing, scene: "my scene/ä&b", ui: false },
      { ...nothing, layers: ["skin", "contacts"], camera: "close", pauseAt: 2.125 },
      { ...nothing, weights: ["index-intermediate", "thumb-distal"] },
      { ...nothing, layers: [], camera: { position: [0.1, -0.2, 0.3], target: [0, 0, 0.05], fov: null } },
      { ...nothing, camera: { position: [1, 2, 3], target: [0, 0, 0], fov: 24.5 } },
    ];
    for (const link of links) expect(parseLink(formatLink(link))).toEqual(link);
  });

  it("read the documented example", () => {
    const link = parseLink("#scene=bread-grasp&layers=skin,contacts&camera=front&t=2.1&ui=off");
    expect(link.scene).toBe("bread-grasp");
    expect(link.layers).toEqual(["skin", "contacts"]);
    expect(link.camera).toBe("front");
    expect(link.pauseAt).toBe(2.1);
    expect(link.ui).toBe(false);
    expect(parseLink("#pause-at=3").pauseAt).toBe(3);
  });

  it("leave out what makes no sense", () => {
    const junk = [
      "#camera=1,2,3",
      "#camera=1,2,3,4,5,x",
      "#camera=1,2,3,1,2,3",
      "#camera=1e9,0,0,0,0,0",
      "#camera=1,2,3,0,0,0,500",
      "#t=-1",
      "#t=soon",
      "#t=",
      "#t=Infinity",
      "#scene=",
      "#%%%",
      "#&&==&",
    ];
    for (const hash of junk) expect(parseLink(hash)).toEqual(nothing);
    expect(parseLink("#layers=skin,<script>,").layers).toEqual(["skin"]);
  });
});
