import "./style.css";
import { createApp, publishStatus } from "./app";
import { mountUi } from "./ui/ui";
import { installTracking } from "./xr/install";

function start(canvas: HTMLCanvasElement, root: HTMLElement): void {
  const app = createApp(canvas);
  publishStatus(app);
  mountUi(app, root);
  installTracking(app);
  app.stage.start();
  app.connection.connect();
}

const canvas = document.querySelector<HTMLCanvasElement>("#stage");
const root = document.querySelector<HTMLElement>("#ui");
if (canvas === null || root === null) throw new Error("The page lacks its canvas.");

if (document.createElement("canvas").getContext("webgl2") !== null) start(canvas, root);
else {
  root.className = "no-webgl";
  root.textContent =
    "This page draws with WebGL 2, which this browser does not offer. Another browser may, or this " +
    "one after hardware acceleration or updates are switched on in its settings.";
}
