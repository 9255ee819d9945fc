// Pictures of the view, and links to it.

import { LAYERS } from "../../scene/layers";
import type { Desk, Panel } from "../desk";
import { button, h } from "../dom";
import { fileStem, fixed } from "../format";
import { ICONS } from "../icons";
import { formatLink, type ViewLink } from "../view-link";
import { download, group, select } from "../widgets";

const SIZES = [
  ["now", "As on the screen"],
  ["1280x720", "1280 × 720"],
  ["1920x1080", "1920 × 1080"],
] as const;

export function picturePanel(desk: Desk): Panel {
  const { connection, feed, stage } = desk.app;
  const size = select("Size", SIZES, () => undefined);

  const pixels = (): [number, number] => {
    const [width, height] = size.input.value.split("x").map(Number);
    if (height !== undefined) return [width, height];
    const { clientWidth, clientHeight } = stage.canvas;
    const ratio = Math.min(2, window.devicePixelRatio);
    return [Math.round(clientWidth * ratio), Math.round(clientHeight * ratio)];
  };
  const take = async () => {
    try {
      const [width, height] = pixels();
      const blob = await stage.screenshot(width, height);
      const time = fixed(feed.snapshot?.time ?? 0, 2);
      const name = `${fileStem(feed.model?.scene ?? "thenar")}-${time}s.png`;
      download(blob, name);
      desk.toasts.show(`Saved ${name}, ${width} × ${height}.`);
    } catch (error) {
      desk.toasts.show(`No picture could be taken: ${String(error)}`, "error");
    }
  };
  const copy = async () => {
    const url = new URL(window.location.href);
    url.hash = formatLink(presentView());
    // The pairing token is for this person; a link is for others.
    url.searchParams.delete("token");
    try {
      await navigator.clipboard.writeText(url.href);
      desk.toasts.show("The link is copied.");
    } catch {
      address.hidden = false;
      address.value = url.href;
      address.focus();
      address.select();
    }
  };
  const presentView = (): ViewLink => {
    const { camera, controls } = stage;
    const { position: p } = camera;
    const { target: t } = controls;
    return {
      scene: feed.model?.scene ?? null,
      layers: LAYERS.filter((layer) => stage.layer(layer)),
      weights: stage.layer("weights") && stage.weightBones.length > 0 ? stage.weightBones : null,
      camera: { position: [p.x, p.y, p.z], target: [t.x, t.y, t.z], fov: camera.fov },
      pauseAt: connection.status?.paused === true ? (connection.snapshot?.time ?? null) : null,
      ui: true,
    };
  };
  const address = h("input", {
    type: "text",
    readonly: true,
    hidden: true,
    "aria-label": "Link to this view",
  });

  desk.keys.add({ key: "i", label: "Save a picture", group: "Picture", act: () => void take() });
  desk.keys.add({
    key: "shift+c",
    name: "Shift C",
    label: "Copy a link to this view",
    group: "Picture",
    act: () => void copy(),
  });
  return {
    id: "picture",
    title: "Picture",
    icon: ICONS.picture,
    body: h(
      "div",
      {},
      size.element,
      h(
        "div",
        { class: "buttons" },
        button("Save a picture", () => void take(), { class: "primary", title: "Key I" }),
      ),
      group(
        "Link",
        h(
          "p",
          { class: "help" },
          "Scene, layers and camera go into the address; while paused, the moment too.",
        ),
        h(
          "div",
          { class: "buttons" },
          button("Copy a link to this view", () => void copy()),
        ),
        address,
      ),
    ),
  };
}
