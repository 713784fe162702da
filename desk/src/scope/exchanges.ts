// Machines whose tables a run receives in motion.

import type { Bench } from "../core/bench";
import { packed, type Given } from "../core/files";
import type { Files, MachineStore } from "../core/machine";

export class Exchanges {
  /** Machines that were dropped or picked, by name. */
  private readonly given = new Map<string, Files>();

  constructor(
    private readonly bench: Bench,
    private readonly machine: MachineStore,
  ) {}

  /** Reads files of a machine; tables alone are added to the present machine. Returns the machine's name. */
  async give(given: readonly Given[]): Promise<string> {
    const taken = JSON.parse(await this.bench.call("machine_from_files", this.machine.json, ...packed(given))) as { name: string; files: Files };
    const name = taken.name.replace(/[^\w.-]+/g, "-").replace(/^[.-]+/, "") || "given";
    this.given.set(name, taken.files);
    return name;
  }

  /** Files of a source of [`Acts`], with a name that is not yet in `known`. */
  async of(source: string, own: Files, known: Record<string, Files>): Promise<{ name: string; files: Files }> {
    if (source === "edited") return named("edited", this.machine.files, known);
    if (source === "half") return named("half-tables", JSON.parse(await this.bench.call("scope_scaled", JSON.stringify(own), 0.5)) as Files, known);
    const name = source.replace(/^given:/, "");
    const files = this.given.get(name);
    if (!files) throw new Error(`exchange: found no machine ${name}, needed one that was opened`);
    return named(name, files, known);
  }
}

function named(wanted: string, files: Files, known: Record<string, Files>): { name: string; files: Files } {
  const same = JSON.stringify(files);
  const free = (name: string) => name !== "machine" && (!(name in known) || JSON.stringify(known[name]) === same);
  let name = wanted;
  for (let i = 2; !free(name); i++) name = `${wanted}-${i}`;
  return { name, files };
}
