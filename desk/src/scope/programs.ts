// The part program: one of those built in, or a file.

import { choice, el, section } from "../core/dom";
import { picker, text, type Given } from "../core/files";
import type { BuiltIn } from "./documents";
import { Listing } from "./listing";
import type { ProgramOf } from "./setup";

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
  private file: { name: string; text: string } | undefined;

  constructor(host: ProgramsHost, chose: (line: number) => void) {
    this.listing = new Listing(chose);
    this.which = choice<string>("Program", [], "", (value) => host.program(value === FILE && this.file ? this.file : { builtin: value }));
    const open = picker("Open program or settings…", { accept: ".ngc,.nc,.gcode,.tap,.cnc,.txt,.toml" }, (files) => host.taken(files), (error) => host.failed(error));
    const hint = el("p", { class: "note" }, "Programs, settings (TOML) and folders of machines may also be dropped anywhere on this view.");
    this.root = section("Part program", this.which.root, el("div", { class: "row" }, open), this.listing.root, hint);
  }

  /** The programs that are built in. */
  builtIn(programs: readonly BuiltIn[]): void {
    this.which.select.prepend(...programs.map(({ name, description }) => el("option", { value: name }, `${name}: ${description}`)));
  }

  /** Shows which program is run, and its lines. */
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

/** What was dropped or picked: a program, settings, or the files of a machine. */
export type Taken = { program: { name: string; text: string } } | { settings: string; file: string } | { machine: Record<string, string>; name: string };

/** Sorts files by what they are. */
export function sort(files: readonly Given[]): Taken {
  const description = files.find(({ path }) => /(^|\/)machine\.toml$/.test(path));
  if (description) {
    const folder = description.path.slice(0, -"machine.toml".length);
    const own = files.filter(({ path }) => path.startsWith(folder) && /\.(toml|csv|txt)$/i.test(path));
    const machine = Object.fromEntries(own.map((file) => [file.path.slice(folder.length), decoded(file)]));
    return { machine, name: folder.split("/").filter(Boolean).at(-1) ?? "given" };
  }
  const [file] = files;
  if (!file) throw new Error("found no file, needed a part program, settings (.toml) or the folder of a machine");
  if (files.length > 1) throw new Error(`found ${files.length} files without a machine.toml, needed one part program, one .toml, or the folder of a machine`);
  if (/\.toml$/i.test(file.path)) return { settings: decoded(file), file: file.path };
  // Comments of a program may be in any encoding.
  const name = file.path.split("/").at(-1) ?? "program.ngc";
  return { program: { name, text: text(file.bytes) ?? new TextDecoder("latin1").decode(file.bytes) } };
}

function decoded(file: Given): string {
  const found = text(file.bytes);
  if (found === undefined) throw new Error(`${file.path}: found bytes that are not UTF-8, needed a text`);
  return found;
}
