// The module's response: the document of a predicted part, and its features as a picture.

import type { Shown } from "../core/shown-types";
import type { Vector } from "../core/space";

export type Verdict = "conforms" | "undecided" | "does not conform";

export interface Characteristic {
  feature: string;
  kind: string;
  association?: string;
  datums: string[];
  uncorrected_um: number;
  corrected_um: number;
  /** With the servo. */
  everything_um?: number;
  limits_um: [least: number | null, most: number | null];
  /** What follows is absent if the machine states no uncertainty. */
  expanded_um?: number;
  interval_um?: { low: number; high: number };
  conformance?: number;
  verdict?: Verdict;
  budget?: { term: string; standard_um: number; share: number }[];
}

export interface Shape {
  feature: string;
  kind: "circle" | "hole" | "line" | "plane" | "profile" | "flank";
  closed: boolean;
  points_mm: Vector[];
  uncorrected_um: Vector[];
  corrected_um: Vector[];
  /** With the servo. */
  everything_um?: Vector[];
  verdict: Verdict | null;
  used: number | null;
}

/** The part at a place. */
export interface There {
  document: { part: string; at_mm: Vector; features: Characteristic[] };
  /** Share of each tolerance that is used. */
  used: number[];
  shapes: Shape[];
}

export interface Predicted extends There {
  shown: Shown;
  notes: string[];
}

/** What to measure. */
export interface Advised {
  shown: Shown;
  /** The task of `calibrate plan`. */
  task: string | null;
}

export interface Kept {
  /** Lowest and highest place along X, Y and Z. */
  range_mm: [Ends, Ends, Ends];
  /** Temperature of a machine that grows. */
  machine_c: number | null;
}
export type Ends = [low: number, high: number];

/** Name and text of a file. */
export type Text = [name: string, text: string];

export interface Request {
  part: Text;
  program: Text;
  /** Programs of further set-ups, and tasks of instruments. */
  more: Text[];
  /** The machine's thermal.toml. */
  thermal?: Text | null;
  /** A record of temperatures. */
  record?: Text | null;
  /** Start of the program in the record: seconds after its first row, or HH:MM. */
  start?: string;
  at_mm: Vector | null;
  machine_c?: number | null;
  trials: number;
  seed: number;
}

/** A characteristic with its datums, as the command line names it. */
export function titled({ feature, kind: of, association, datums }: Characteristic): string {
  const kind = association === "minimum zone" ? `${of}, ${association}` : of;
  if (datums.length === 0) return `${feature}, ${kind}`;
  return `${feature}, ${kind} ${kind === "distance" ? "from" : "to"} ${datums.join(", ")}`;
}
