// EventTarget with typed names and payloads.

export class Emitter<Events extends object> {
  private readonly target = new EventTarget();

  /** Listens; call what comes back to stop. */
  on<K extends keyof Events & string>(name: K, listener: (payload: Events[K]) => void): () => void {
    const wrapped = (event: Event) => listener((event as CustomEvent<Events[K]>).detail);
    this.target.addEventListener(name, wrapped);
    return () => this.target.removeEventListener(name, wrapped);
  }

  protected emit<K extends keyof Events & string>(name: K, payload: Events[K]): void {
    this.target.dispatchEvent(new CustomEvent(name, { detail: payload }));
  }
}
