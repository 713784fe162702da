// The files of a part: its own with the programs and tasks that it names, the machine, temperatures.

import type { Desk } from "../core/desk";
import { plainName, text, type Given } from "../core/files";
import { isProgram, mainOf } from "../core/programs";
import { adopt } from "../core/machine";
import type { Request, Text } from "./documents";

type Draws = Pick<Request, "trials" | "seed">;
/** A request without what it cannot do without. */
export const NO_FILES: Omit<Request, "part" | "program" | keyof Draws> = { more: [], thermal: null, record: null, start: "", at_mm: null, machine_c: null };

/** A request to predict, or what is missing for one. */
type Taken = { request: Request; sample: boolean } | string | undefined;

const isToml = ([name]: Text) => name.toLowerCase().endsWith(".toml");

/** Whether a CSV is a record of temperatures: its header has a time. */
function isRecord([name, content]: Text): boolean {
  const header = content.split(/\r?\n/).find((line) => line.trim() !== "" && !/^[#;]/.test(line)) ?? "";
  return /\.(csv|txt)$/i.test(name) && /(^|[,;\t])\s*t_s\s*([,;\t]|$)/.test(header);
}

export class Files {
  /** The program that the part names, and its further files: of set-ups and of instruments. */
  private program = "";
  private named: string[] = [];
  /** A part without its program, or a program without its part. */
  private partial: Partial<Pick<Request, "part" | "program">> = {};
  /** Those of the further files that are there. */
  private more: Text[] = [];

  constructor(private readonly desk: Desk) {}

  /** Any of the files; the others are those of the request so far. */
  async take(given: Given[], old: Request | undefined, sample: boolean, draws: Draws): Promise<Taken> {
    const texts = new Map<string, string>();
    for (const { path, bytes } of given) {
      const name = plainName(path);
      const content = text(bytes);
      if (content === undefined) throw new Error(`${name}: found bytes that are not UTF-8, needed a text`);
      texts.set(name, content);
    }
    const record = [...texts].find(isRecord);
    if (record) texts.delete(record[0]);
    const growth = texts.get("thermal.toml");
    texts.delete("thermal.toml");
    const isMachine = await this.machine(texts, given);
    // Another machine grows otherwise.
    const thermal: Text | null = growth !== undefined ? ["thermal.toml", growth] : isMachine ? null : (old?.thermal ?? null);
    const temperatures = { thermal, record: record ?? old?.record ?? null, start: record ? "" : (old?.start ?? "") };

    const rest = [...texts];
    const part = await this.partOf(rest.filter((one) => isToml(one) && !this.named.includes(one[0])));
    const programs = rest.filter((one) => one !== part && !this.named.includes(one[0]) && !isToml(one));
    const program = programs.find(([name]) => name === this.program) ?? this.main(programs);
    // With the files of subprograms.
    const more = rest.filter((one) => one !== part && one !== program && (this.named.includes(one[0]) || isProgram(one[0])));
    const before = part || sample ? [] : (old?.more ?? this.more);
    this.more = [...before.filter(([name]) => !more.some(([own]) => own === name)), ...more];
    if (!part && !program) {
      const isChanged = record || growth !== undefined || more.length > 0 || thermal !== (old?.thermal ?? null);
      return old && isChanged ? { request: { ...old, ...draws, ...temperatures, more: this.more }, sample } : undefined;
    }

    const own = sample ? undefined : old;
    // The other one may follow.
    this.partial = { ...this.partial, ...(own && { part: own.part, program: own.program }), ...(part && { part }), ...(program && { program }) };
    const found = this.partial;
    if (!found.part || !found.program)
      return found.part ? `${found.part[0]}: open its program${this.program ? `, ${this.program}` : ""}, too.` : `${found.program![0]}: open its part.toml, too.`;
    this.partial = {};
    return { request: { ...NO_FILES, ...draws, ...temperatures, part: found.part, program: found.program, more: this.more }, sample: false };
  }

  private main(programs: readonly Text[]): Text | undefined {
    const [only, other] = programs;
    if (!other) return only;
    const main = mainOf(Object.fromEntries(programs));
    return programs.find(([name]) => name === main);
  }

  /** Takes a machine with its tables out of the texts, and shows it on the desk. */
  private async machine(texts: Map<string, string>, given: Given[]): Promise<boolean> {
    if (!texts.has("machine.toml")) return false;
    const files = [...texts].filter(([name]) => name === "machine.toml" || name.endsWith(".csv"));
    await adopt(this.desk, Object.fromEntries(files), { what: "opened" }, given.find(({ path }) => path.endsWith("machine.toml"))?.path.split("/").at(-2) ?? "machine");
    for (const [name] of files) texts.delete(name);
    return true;
  }

  /** The first of these files that is a part's; what it names is kept. */
  private async partOf(given: Text[]): Promise<Text | undefined> {
    let refused: unknown;
    for (const one of given) {
      try {
        const files = await this.desk.bench.call("predict_files", ...one);
        [this.program, ...this.named] = files.map(plainName) as [string, ...string[]];
        return one;
      } catch (error) {
        refused ??= error;
      }
    }
    if (refused !== undefined) throw refused;
    return undefined;
  }
}
