// Recording in memory, replay with a scrubber, files.

import { read, write } from "../../record/container";
import { Player } from "../../record/player";
import { BOUNDS, Recorder } from "../../record/recorder";
import type { Desk, Panel } from "../desk";
import { takeDrops } from "../drops";
import { button, h, setText } from "../dom";
import { bytes, fileStem, fixed } from "../format";
import { ICONS } from "../icons";
import { download, group, select } from "../widgets";

const SPEEDS = [
  ["0.1", "0.1 ×"],
  ["0.25", "0.25 ×"],
  ["0.5", "0.5 ×"],
  ["1", "1 ×"],
  ["2", "2 ×"],
] as const;

export function recordPanel(desk: Desk): Panel {
  const { connection, feed, stage } = desk.app;
  const recorder = new Recorder();
  let recording = false;
  let player: Player | null = null;
  let shown = -1;
  const fail = (error: unknown) =>
    desk.toasts.show(error instanceof Error ? error.message : String(error), "error");

  const now = () => performance.now() / 1000;
  const startStop = () => {
    if (recording) {
      recording = false;
      refresh();
      return;
    }
    if (connection.modelBytes === null) {
      desk.toasts.show("There is nothing to record: no simulation is connected.", "warning");
      return;
    }
    live();
    recorder.begin(connection.modelBytes, now());
    recording = true;
    refresh();
  };
  connection.on("binary", (message) => {
    if (recording) recorder.add(message, now());
  });

  const open = (next: Player) => {
    recording = false;
    player = next;
    player.speed = Number(speed.input.value);
    shown = -1;
    player.playing = true;
    draw();
    refresh();
  };
  const live = () => {
    player = null;
    feed.backToLive();
    refresh();
  };
  const replay = () => {
    if (recorder.snapshots === 0) return;
    open(new Player(recorder.entries()));
  };
  const save = () => {
    const stem = fileStem(feed.model?.scene ?? "recording");
    download(
      new Blob(write(recorder.entries()), { type: "application/octet-stream" }),
      `${stem}.thenar-recording`,
    );
  };
  const load = async (file: File) => {
    try {
      const loaded = read(await file.arrayBuffer());
      const next = new Player(loaded.entries);
      next.show(performance.now());
      open(next);
      if (loaded.lacks !== null) desk.toasts.show(loaded.lacks, "warning");
      if (loaded.damage !== null) desk.toasts.show(`The recording is damaged. ${loaded.damage}`, "warning");
    } catch (error) {
      fail(error);
    }
  };

  /** Shows the player's place, if it is not shown yet. */
  const draw = () => {
    if (player === null) return;
    const { index } = player;
    if (index !== shown) {
      shown = index;
      try {
        const moment = player.show(performance.now());
        feed.showRecorded(moment.model, moment.snapshot);
      } catch (error) {
        fail(error);
        live();
        return;
      }
    }
    if (document.activeElement !== scrub || player.playing) scrub.value = String(player.time);
    setText(
      place,
      `${fixed(player.time, 2)} of ${fixed(player.duration, 2)} s, snapshot ${index + 1} of ${player.length}`,
    );
    setText(play, player.playing ? "Pause" : "Play");
  };
  stage.onFrame((_, dt) => {
    if (player === null || !player.playing) return;
    player.advance(dt);
    draw();
  });

  const record = button("Record", startStop, { class: "primary" });
  const held = h("p", { class: "help", "aria-live": "off" });
  const watch = button("Replay", replay);
  const keep = button("Save to a file", save);
  const file = h("input", {
    type: "file",
    accept: ".thenar-recording",
    hidden: true,
    "aria-label": "Recording to load",
  });
  file.addEventListener("change", () => {
    const chosen = file.files?.[0];
    file.value = "";
    if (chosen !== undefined) void load(chosen);
  });
  takeDrops({
    what: "a recording (.thenar-recording)",
    pattern: /\.thenar-recording$/i,
    open: (dropped) => void load(dropped),
  });
  const fetchFile = button("Load a file", () => file.click());

  const scrub = h("input", { type: "range", min: 0, step: "any", "aria-label": "Place in the recording" });
  scrub.addEventListener("input", () => {
    if (player === null) return;
    player.playing = false;
    player.time = Number(scrub.value);
    draw();
  });
  const place = h("p", { class: "help" });
  const stepBy = (count: number) => () => {
    player?.step(count);
    draw();
  };
  const play = button("Play", () => {
    if (player === null) return;
    if (!player.playing && player.time >= player.duration) player.time = 0;
    player.playing = !player.playing;
    draw();
  });
  const speed = select("Replay speed", SPEEDS, (value) => {
    if (player !== null) player.speed = Number(value);
  });
  speed.input.value = "1";
  const replayGroup = group(
    "Replay",
    scrub,
    place,
    h("div", { class: "buttons" }, play, button("◂ Frame", stepBy(-1)), button("Frame ▸", stepBy(1))),
    speed.element,
    button("Back to live", live, { class: "primary" }),
  );

  desk.keys.add({
    key: "shift+r",
    name: "Shift R",
    label: "Record, and stop recording",
    group: "Recording",
    act: startStop,
  });
  const replaying = { group: "Recording", when: () => !desk.app.feed.live };
  desk.keys.add({ key: ",", label: "Replay: one snapshot back", act: stepBy(-1), ...replaying });
  desk.keys.add({ key: ".", label: "Replay: one snapshot on", act: stepBy(1), ...replaying });

  const refresh = () => {
    record.textContent = recording ? "Stop recording" : "Record";
    document.documentElement.classList.toggle("recording", recording);
    const some = recorder.snapshots > 0;
    watch.disabled = !some;
    keep.disabled = !some;
    replayGroup.hidden = player === null;
    if (player !== null) scrub.max = String(player.duration);
    say();
  };
  const say = () => {
    const limit = `At most ${BOUNDS.seconds} s or ${bytes(BOUNDS.bytes)} are kept, in this page's memory; then the oldest go.`;
    const n = recorder.snapshots;
    const got = n === 0 ? "" : `${fixed(recorder.seconds, 1)} s, ${n} snapshots, ${bytes(recorder.bytes)}. `;
    const lost = recorder.dropped === 0 ? "" : `The oldest ${recorder.dropped} snapshots are gone. `;
    setText(held, got + lost + limit);
  };
  setInterval(() => {
    if (recording) {
      say();
      watch.disabled = keep.disabled = recorder.snapshots === 0;
    }
  }, 500);
  refresh();
  return {
    id: "record",
    title: "Record",
    icon: ICONS.record,
    body: h(
      "div",
      {},
      held,
      h("div", { class: "buttons" }, record, watch, keep, fetchFile),
      file,
      replayGroup,
    ),
  };
}
