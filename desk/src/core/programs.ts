// Part programs given together: the main one, and the files of its subprograms.

import { plainName, text, type Given } from "./files";

/** Texts of files by name. */
type Texts = Readonly<Record<string, string>>;

const ENDING = /\.(ngc|nc|gcode|tap|cnc|txt)$/i;
export const isProgram = (path: string) => ENDING.test(path);

/** The text of a program, whose comments may be in any encoding. */
export const programText = (bytes: Uint8Array) => text(bytes) ?? new TextDecoder("latin1").decode(bytes);

/** The one program that no other one calls. */
export function mainOf(programs: Texts): string {
  const calls = (body: string, name: string) => {
    const own = name.replace(/\.[^.]*$/, "").replace(/[^\w-]/g, "\\$&");
    return new RegExp(`o\\s*(<\\s*${own}\\s*>|${own}\\s)\\s*call|M98\\s*P0*${own}\\b`, "i").test(body);
  };
  const names = Object.keys(programs);
  const main = names.filter((name) => !Object.entries(programs).some(([other, body]) => other !== name && calls(body, name)));
  if (main.length === 1) return main[0]!;
  throw new Error(`found ${names.length} programs, ${main.length === 0 ? "each called by another one" : `${main.join(" and ")} called by no other one`}; needed one with the files of its subprograms`);
}

/** Files that are all part programs: the main one, and the others by name. */
export function programs(files: readonly Given[]): { name: string; text: string; files?: Record<string, string> } {
  const texts = Object.fromEntries(files.map(({ path, bytes }) => [plainName(path), programText(bytes)]));
  const name = mainOf(texts);
  const { [name]: main, ...others } = texts;
  return { name, text: main!, ...(files.length > 1 ? { files: others } : {}) };
}
