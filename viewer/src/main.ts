import "./style.css";
import { createApp, publishStatus } from "./app";
import { mountUi } from "./ui/ui";

const canvas = document.querySelector<HTMLCanvasElement>("#stage");
const root = document.querySelector<HTMLElement>("#ui");
if (canvas === null || root === null) throw new Error("The page lacks its canvas.");

const app = createApp(canvas);
publishStatus(app);
mountUi(app, root);
app.stage.start();
app.connection.connect();
