// Files dropped anywhere on the page: what takes them, or what the page would take.

export interface FileTaker {
  /** "a hand motion (.jsonl)" */
  readonly what: string;
  /** Of the file's name. */
  readonly pattern: RegExp;
  readonly open: (file: File) => void;
}

/** Why a file is of no use here. */
export function dropRefusal(name: string, takers: readonly FileTaker[]): string {
  const kinds = takers.map(({ what }) => what).join(" or ");
  return `The page takes ${kinds}; ${name} is neither.`;
}

const takers: FileTaker[] = [];

/** A part of the page takes files of its kind. */
export function takeDrops(taker: FileTaker): void {
  takers.push(taker);
}

/** Without this the browser opens what is dropped, in place of the page. */
export function acceptDrops(refused: (reason: string) => void): void {
  const files = (event: DragEvent) => event.dataTransfer?.types.includes("Files") === true;
  window.addEventListener("dragover", (event) => {
    if (files(event)) event.preventDefault();
  });
  window.addEventListener("drop", (event) => {
    if (!files(event)) return;
    event.preventDefault();
    const file = event.dataTransfer?.files[0];
    if (file === undefined) return;
    const taker = takers.find(({ pattern }) => pattern.test(file.name));
    if (taker === undefined) refused(dropRefusal(file.name, takers));
    else taker.open(file);
  });
}
