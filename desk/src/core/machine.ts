// The machine shared by all views: the texts of its files.

import type { Bench } from "./bench";

export type Files = Record<string, string>;

export class MachineStore {
  private listeners = new Set<() => void>();
  name = "";
  files: Files = {};
  /** The files in the module's format. */
  json = "{}";
  /** The files as they were opened. */
  private opened: Files = {};

  /** Sets another machine, or the same one after an edit. The module must have read the files. */
  set(name: string, files: Files, opened = name !== this.name): void {
    if (opened) this.opened = files;
    this.name = name;
    this.files = files;
    this.json = JSON.stringify(files);
    for (const listener of this.listeners) listener();
  }

  /** Names of the files that differ from those that were opened. */
  get changed(): string[] {
    const names = new Set([...Object.keys(this.opened), ...Object.keys(this.files)]);
    return [...names].filter((name) => this.opened[name] !== this.files[name]);
  }

  subscribe(listener: () => void): void {
    this.listeners.add(listener);
  }
}

/** Makes the edited files the machine that all views share, once the module has read them. */
export async function adopt({ bench, machine }: { bench: Bench; machine: MachineStore }, files: Files, name = machine.name): Promise<void> {
  await bench.call("machine_open", JSON.stringify(files));
  machine.set(name, files);
}
