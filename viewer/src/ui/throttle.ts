// Sends the newest value at most every `interval` ms: the first at once, the last always.

export class Throttle<T> {
  private timer: ReturnType<typeof setTimeout> | undefined;
  private waiting: { value: T } | null = null;

  constructor(
    private readonly interval: number,
    private readonly act: (value: T) => void,
  ) {}

  push(value: T): void {
    if (this.timer !== undefined) {
      this.waiting = { value };
      return;
    }
    this.act(value);
    this.timer = setTimeout(() => this.due(), this.interval);
  }

  /** True while a value waits or was sent a moment ago. */
  get busy(): boolean {
    return this.timer !== undefined;
  }

  private due(): void {
    this.timer = undefined;
    const waiting = this.waiting;
    this.waiting = null;
    if (waiting !== null) this.push(waiting.value);
  }
}
