import "./style.css";
import { createApp, publishStatus } from "./app";
import { mountUi } from "./ui/ui";
import { installTracking } from "./xr/install";

const canvas = document.querySelector<HTMLCanvasElement>("#stage");
const root = document.querySelector<HTMLElement>("#ui");
if (canvas === null || root === null) throw new Error("The page lacks its canvas.");

const app = createApp(canvas);
publishStatus(app);
mountUi(app, root);
installTracking(app);
app.stage.start();
app.connection.connect();
