// The machine shared by all views: the texts of its files, and the history of its changes.

import type { Bench } from "./bench";

export type Files = Record<string, string>;

/** What undo restores. */
interface State {
  name: string;
  files: Files;
  /** The files as they were opened, and the number of changes since. */
  opened: Files;
  changes: number;
  /** The files before a measured correction, if that is the last change. */
  before: Files | undefined;
}

/** A change of the machine, for its history. */
export interface Change {
  what?: string;
  /** Whether it belongs to the previous change, as the steps of one gesture do. */
  joined?: boolean;
  /** Whether it is a correction that was measured. */
  measured?: boolean;
  /** The machine that was measured, if it is not the one shown: opened first. */
  own?: Files | undefined;
}

const MOST_STEPS = 200;

export class MachineStore {
  private listeners = new Set<() => void>();
  private state: State = { name: "", files: {}, opened: {}, changes: 0, before: undefined };
  private readonly back: [State, string][] = [];
  private readonly forth: [State, string][] = [];
  /** The files in the module's format. */
  json = "{}";

  get name(): string {
    return this.state.name;
  }

  get files(): Files {
    return this.state.files;
  }

  /** Number of changes since the machine was opened. */
  get changes(): number {
    return this.state.changes;
  }

  /** The files before a measured correction, as long as that is the last change. */
  get before(): Files | undefined {
    return this.state.before;
  }

  /** Names of the files that differ from those that were opened. */
  get changed(): string[] {
    const { opened, files } = this.state;
    const names = new Set([...Object.keys(opened), ...Object.keys(files)]);
    return [...names].filter((name) => opened[name] !== files[name]);
  }

  get undoable(): string | undefined {
    return this.back.at(-1)?.[1];
  }

  get redoable(): string | undefined {
    return this.forth.at(-1)?.[1];
  }

  /** The files that undo and redo would restore. */
  get undone(): Files | undefined {
    return this.back.at(-1)?.[0].files;
  }

  get redone(): Files | undefined {
    return this.forth.at(-1)?.[0].files;
  }

  /** Opens a machine without a history. The module must have read the files. */
  open(name: string, files: Files): void {
    this.back.length = this.forth.length = 0;
    this.take(opened(name, files));
  }

  /** Sets another machine, or the same one after a change. The module must have read the files. */
  set(name: string, files: Files, { what, joined = false, measured = false, own }: Change = {}): void {
    if (own) {
      this.keep(`opened ${name}`);
      this.state = opened(name, own);
    }
    const { state } = this;
    if (name === state.name && JSON.stringify(files) === this.json) return this.take(state);
    if (!joined || this.back.length === 0) this.keep(what ?? (name === state.name ? "changed" : `opened ${name}`));
    this.forth.length = 0;
    if (name !== state.name) return this.take(opened(name, files));
    this.take({ ...state, files, changes: state.changes + (joined && state.changes > 0 ? 0 : 1), before: measured ? state.files : undefined });
  }

  /** Takes the last change back; returns its name. */
  undo(): string | undefined {
    return this.exchange(this.back, this.forth);
  }

  redo(): string | undefined {
    return this.exchange(this.forth, this.back);
  }

  subscribe(listener: () => void): void {
    this.listeners.add(listener);
  }

  private exchange(from: [State, string][], to: [State, string][]): string | undefined {
    const step = from.pop();
    if (!step) return undefined;
    const [state, what] = step;
    to.push([this.state, what]);
    this.take(state);
    return what;
  }

  private keep(what: string): void {
    this.back.push([this.state, what]);
    if (this.back.length > MOST_STEPS) this.back.shift();
  }

  private take(state: State): void {
    this.state = state;
    this.json = JSON.stringify(state.files);
    for (const listener of this.listeners) listener();
  }
}

function opened(name: string, files: Files): State {
  return { name, files, opened: files, changes: 0, before: undefined };
}

/** Makes the corrected files the machine that all views share, once the module has read them. */
export async function adopt({ bench, machine }: { bench: Bench; machine: MachineStore }, files: Files, change: Change, name = machine.name): Promise<void> {
  await bench.call("machine_open", JSON.stringify(files));
  machine.set(name, files, change);
}
