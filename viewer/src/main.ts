import "./style.css";
import { createApp, publishStatus } from "./app";

const canvas = document.querySelector<HTMLCanvasElement>("#stage");
if (canvas === null) throw new Error("The page lacks its canvas.");

const app = createApp(canvas);
publishStatus(app);
app.stage.start();
app.connection.connect();
