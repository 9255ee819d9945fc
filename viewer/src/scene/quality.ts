// How much to spend on a picture: software rendering gets less, and so does a screen that lags.

export interface Quality {
  /** The processor draws, not a graphics chip. */
  readonly software: boolean;
  readonly antialias: boolean;
  /** Fine relief of surfaces. */
  readonly detail: boolean;
  /** Light kept out by near bodies. */
  readonly occlusion: boolean;
  readonly shadowSize: number;
  readonly shadowTaps: number;
  readonly pixelRatioMost: number;
}

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

export function rendererName(gl: WebGLRenderingContext | WebGL2RenderingContext): string {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return String(gl.getParameter(info === null ? gl.RENDERER : info.UNMASKED_RENDERER_WEBGL));
}

/** Asks a context of its own: antialiasing must be decided before the real one is made. */
function isSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (gl === null) return false;
  const software = SOFTWARE.test(rendererName(gl));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return software;
}

/** `wish`: "high" or "low" overrule what the renderer's name suggests. */
export function chooseQuality(wish: string | null): Quality {
  const software = isSoftware();
  const high = wish === "high" || (wish !== "low" && !software);
  return high
    ? {
        software: false,
        antialias: true,
        detail: true,
        occlusion: true,
        shadowSize: 2048,
        shadowTaps: 16,
        pixelRatioMost: 2,
      }
    : {
        software,
        antialias: !software,
        detail: false,
        occlusion: false,
        shadowSize: 512,
        shadowTaps: 5,
        pixelRatioMost: 1,
      };
}

/** Frames longer than this are slow, s. */
const SLOW = 1 / 35;
/** A pause longer than this is no frame: the page was hidden, s. */
const PAUSE = 3;
/** Slow frames for this long lower the number of pixels, s. */
const PATIENCE = 1.5;

/** Lowers the number of pixels while frames take too long; never raises it by itself. */
export class PixelBudget {
  scale = 1;
  private slow = 0;

  constructor(private readonly least: number) {}

  /** One frame's length, s. True when the scale changed. */
  frame(dt: number): boolean {
    if (dt > PAUSE) return false;
    this.slow = Math.max(0, this.slow + (dt > SLOW ? dt : -0.5 * dt));
    if (this.slow < PATIENCE || this.scale <= this.least) return false;
    this.slow = 0;
    this.scale = Math.max(this.least, this.scale * 0.8);
    return true;
  }
}
