// The part program: a built-in one, or a file.

import { choice, el, section } from "../core/dom";
import { picker, plainName, text, type Given } from "../core/files";
import { isProgram, programs } from "../core/programs";
import type { BuiltIn } from "./documents";
import { Listing } from "./listing";
import type { FileOf, ProgramOf } from "./setup";

const FILE = "file:";

export interface ProgramsHost {
  program(program: ProgramOf): void;
  taken(files: Given[]): void;
  failed(error: unknown): void;
}

export class Programs {
  readonly root: HTMLElement;
  readonly listing: Listing;
  private readonly which;
  private file: FileOf | undefined;

  constructor(host: ProgramsHost, chose: (line: number) => void) {
    this.listing = new Listing(chose);
    this.which = choice<string>("Program", [], "", (value) => host.program(value === FILE && this.file ? this.file : { builtin: value }));
    const open = picker("Open program or settings…", { accept: ".ngc,.nc,.gcode,.tap,.cnc,.txt,.toml", several: true }, (files) => host.taken(files), (error) => host.failed(error));
    const hint = el("p", { class: "note" }, "Programs, together with the files of their subprograms, settings (TOML) and folders of machines may also be dropped anywhere on this view.");
    this.root = section("Part program", this.which.root, el("div", { class: "row" }, open), this.listing.root, hint);
  }

  /** The built-in programs. */
  builtIn(programs: readonly BuiltIn[]): void {
    this.which.select.prepend(...programs.map(({ name, description }) => el("option", { value: name }, `${name}: ${description}`)));
  }

  /** Shows the program being run, and its lines. */
  set(program: ProgramOf, lines: readonly string[]): void {
    if ("builtin" in program) this.which.value = program.builtin;
    else {
      this.file = program;
      const option = this.which.select.querySelector<HTMLOptionElement>(`option[value="${FILE}"]`) ?? el("option", { value: FILE });
      option.textContent = program.name;
      this.which.select.append(option);
      this.which.value = FILE;
    }
    this.listing.set(lines);
  }
}

/** Dropped or picked input: a program, settings, or files of a machine. */
export type Taken = { program: FileOf } | { settings: string; file: string } | { machine: readonly Given[] };

/** Sorts files by their kind. */
export function sort(files: readonly Given[]): Taken {
  const [file] = files;
  if (!file) throw new Error("found no file, needed a part program, settings (.toml), or the folder or compiled file of a machine");
  const name = plainName(file.path);
  if (files.every(({ path }) => isProgram(path))) return { program: programs(files) };
  if (files.length > 1 || name === "machine.toml" || /\.(tcomp|csv)$/i.test(name)) return { machine: files };
  const decoded = text(file.bytes);
  if (/\.toml$/i.test(name)) {
    if (decoded === undefined) throw new Error(`${name}: found bytes that are not UTF-8, needed a text`);
    return { settings: decoded, file: name };
  }
  return { program: programs(files) };
}
