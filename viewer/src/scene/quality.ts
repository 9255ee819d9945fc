// How much to spend on a picture: software rendering gets less, and so does a screen that lags.

import type { WebGLRenderer } from "three";

export interface Quality {
  /** The processor draws, not a graphics chip. */
  readonly software: boolean;
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

/** `wish`: "high" or "low" overrule what the renderer's name suggests. */
export function chooseQuality(renderer: WebGLRenderer, wish: string | null): Quality {
  const software = SOFTWARE.test(rendererName(renderer.getContext()));
  const high = wish === "high" || (wish !== "low" && !software);
  return high
    ? { software, detail: true, occlusion: true, shadowSize: 2048, shadowTaps: 16, pixelRatioMost: 2 }
    : { software, detail: false, occlusion: false, shadowSize: 768, shadowTaps: 5, pixelRatioMost: 1 };
}

/** Lowers the number of pixels while frames take too long; never raises it by itself. */
export class PixelBudget {
  scale = 1;
  private slow = 0;

  constructor(private readonly least: number) {}

  /** One frame's length, s. True when the scale changed. */
  frame(dt: number): boolean {
    if (dt >= 0.1) return false;
    this.slow = Math.max(0, this.slow + (dt > 1 / 35 ? 1 : -0.5));
    if (this.slow < 45 || this.scale <= this.least) return false;
    this.slow = 0;
    this.scale = Math.max(this.least, this.scale * 0.8);
    return true;
  }
}
