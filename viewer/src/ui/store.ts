// What the page remembers between visits. Storage may be forbidden, full or hold junk; the page
// works without it.

const PREFIX = "thenar.";

export function remember(key: string, value: unknown): void {
  try {
    localStorage.setItem(PREFIX + key, JSON.stringify(value));
  } catch {
    // Private window or full storage: nothing is remembered.
  }
}

/** What was remembered, if `accept` takes it. */
export function recall<T>(key: string, accept: (value: unknown) => value is T): T | null {
  try {
    const value: unknown = JSON.parse(localStorage.getItem(PREFIX + key) ?? "null");
    return accept(value) ? value : null;
  } catch {
    return null;
  }
}

export const isTrue = (value: unknown): value is true => value === true;

export const isTexts = (value: unknown): value is string[] =>
  Array.isArray(value) && value.length < 100 && value.every((item) => typeof item === "string");
