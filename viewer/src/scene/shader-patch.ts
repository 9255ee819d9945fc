// Changes to three's own shaders. Each change names the text that it replaces; if three no longer
// has that text, drawing must not silently go wrong, so it is an error.

export interface ShaderSource {
  vertexShader: string;
  fragmentShader: string;
}

export function replaceOnce(source: string, from: string | RegExp, to: string): string {
  const changed = source.replace(from, () => to);
  if (changed === source) throw new Error(`three's shader lacks ${String(from)}`);
  return changed;
}

export function replaceVertex(shader: ShaderSource, from: string, to: string): void {
  shader.vertexShader = replaceOnce(shader.vertexShader, from, to);
}

export function replaceFragment(shader: ShaderSource, from: string, to: string): void {
  shader.fragmentShader = replaceOnce(shader.fragmentShader, from, to);
}

/** Adds code before, or after, a place. */
export const before = (place: string, code: string) => `${code}\n${place}`;
export const after = (place: string, code: string) => `${place}\n${code}`;
