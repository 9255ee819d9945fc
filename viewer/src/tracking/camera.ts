// Asks for a camera, and says in plain words why there is none.

const REASONS: Readonly<Record<string, string>> = {
  NotAllowedError: "The camera was refused. Allow it in the browser's address bar, then try again.",
  NotFoundError: "No camera was found.",
  NotReadableError: "The camera is in use by another program.",
  OverconstrainedError: "The camera has no picture of a usable size.",
  SecurityError: "The browser does not let this page use a camera.",
};

export async function openCamera(): Promise<MediaStream> {
  try {
    return await navigator.mediaDevices.getUserMedia({
      audio: false,
      video: { width: { ideal: 640 }, height: { ideal: 480 }, frameRate: { ideal: 30 }, facingMode: "user" },
    });
  } catch (error) {
    const { name, message } = error instanceof Error ? error : { name: "", message: String(error) };
    throw new Error(REASONS[name] ?? `The camera did not start: ${message}`);
  }
}
