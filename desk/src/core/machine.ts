// The machine shared by all views: the texts of its files.

import type { Bench } from "./bench";

export type Files = Record<string, string>;

export class MachineStore {
  private listeners = new Set<() => void>();
  name = "";
  files: Files = {};
  /** The files in the module's format. */
  json = "{}";

  /** Sets another machine, or the same one after an edit. The module must have read the files. */
  set(name: string, files: Files): void {
    this.name = name;
    this.files = files;
    this.json = JSON.stringify(files);
    for (const listener of this.listeners) listener();
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
