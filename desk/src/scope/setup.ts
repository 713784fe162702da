// The inputs of a run: program, settings, error model, acts, and the machines whose tables are exchanged.

import type { Files } from "../core/machine";

/** A program with the files of its subprograms. */
export interface FileOf {
  name: string;
  text: string;
  files?: Files;
}

export type ProgramOf = { builtin: string } | FileOf;
export type Model = "machine" | "nine" | "volumetric";
export type Direction = "machine" | "on" | "off";

/** State of the view that links and files contain. */
export interface Setup {
  program: ProgramOf;
  /** Settings that are not the default: dotted key, value as in TOML; faults and events are separate. */
  settings: Record<string, string>;
  model: Model;
  orientation: Direction;
  /** Faults and events with their times, in the form of the scenario file. */
  acts: string[];
  /** Machines whose tables the acts name. */
  exchanges: Record<string, Files>;
}

export const FIRST: Setup = {
  program: { builtin: "circle-diamond-square" },
  settings: {},
  model: "machine",
  orientation: "machine",
  acts: [],
  exchanges: {},
};

/** Whether an act concerns the plugin, not a fault of the plant. */
export function isEvent(act: string): boolean {
  return /^\s*(on|off|reset|exchange)\b/.test(act);
}

/** Source of the tables of `exchange:NAME@TIMEs`. */
export function exchangeOf(act: string): string | undefined {
  return /^\s*exchange:(.*)@[^@]*$/.exec(act)?.[1]?.trim();
}

/** Settings as a scenario file. */
export function toml(setup: Setup): string {
  const list = (acts: string[]) => `[${acts.map((act) => JSON.stringify(act)).join(", ")}]`;
  const lines = Object.entries(setup.settings).map(([key, value]) => `${key} = ${value}`);
  const events = setup.acts.filter(isEvent);
  const faults = setup.acts.filter((act) => !isEvent(act));
  if (faults.length > 0) lines.push(`faults = ${list(faults)}`);
  if (events.length > 0) lines.push(`events = ${list(events)}`);
  return lines.map((line) => `${line}\n`).join("");
}

/** Response of `scope_settings`. */
export interface SettingsRead {
  settings: Record<string, unknown>;
  changes: { key: string; value: string; default: string }[];
}

/** Replaces the settings of a setup by those of a scenario file. */
export function withSettings(setup: Setup, read: SettingsRead): Setup {
  const { settings } = read;
  const texts = (value: unknown) => (Array.isArray(value) ? value.map(String) : []);
  const own = read.changes.filter(({ key }) => key !== "faults" && key !== "events");
  const acts = [...texts(settings.faults), ...texts(settings.events)];
  return { ...setup, settings: Object.fromEntries(own.map(({ key, value }) => [key, value])), acts };
}

/** Request to `scope_open`. */
export function request(setup: Setup, machine: Files): string {
  const { program, model, orientation, exchanges } = setup;
  return JSON.stringify({
    machine,
    program,
    settings: toml(setup),
    ...(model === "machine" ? {} : { model }),
    ...(orientation === "machine" ? {} : { orientation: orientation === "on" }),
    exchanges,
  });
}

/** A setup from a link or a file. */
export function fromState(state: unknown): Setup {
  const given = (state ?? {}) as Partial<Setup>;
  const setup: Setup = { ...structuredClone(FIRST), ...given };
  const { program } = setup;
  const known = "builtin" in program ? typeof program.builtin === "string" : typeof program.text === "string";
  if (!known || !Array.isArray(setup.acts) || typeof setup.settings !== "object") throw new Error("servo scope: found a state without program, settings and acts, needed one that this page saved");
  return setup;
}

/** Differences between two setups, in words: name, one, other. */
export function differences(one: Setup, other: Setup): [string, string, string][] {
  const name = (setup: Setup) => ("builtin" in setup.program ? setup.program.builtin : setup.program.name);
  const found: [string, string, string][] = [];
  const compare = (what: string, a: string, b: string) => a !== b && found.push([what, a, b]);
  compare("program", name(one), name(other));
  compare("error model", one.model, other.model);
  compare("tool direction", one.orientation, other.orientation);
  for (const key of new Set([...Object.keys(one.settings), ...Object.keys(other.settings)]))
    compare(key, one.settings[key] ?? "default", other.settings[key] ?? "default");
  compare("in motion", one.acts.join(", ") || "nothing", other.acts.join(", ") || "nothing");
  return found;
}
