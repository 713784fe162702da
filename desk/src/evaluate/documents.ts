// The module's response: the contents of the command line's report page.

import type { Becomes } from "../core/becomes";
import type { Cell } from "../core/dom";

export type Test = "step-diagonal" | "r-test" | "points" | "probing" | "thermal";

export interface Curve {
  name: string;
  /** Number of its colour. */
  colour: number;
  dashed: boolean;
  values: (number | null)[];
  /** Standard errors; missing if they are unknown. */
  errors: number[];
}

export interface Plotted {
  title: string;
  /** Quantities to the right and upward, with units. */
  x: [string, string];
  y: [string, string];
  look: "line" | "dotted" | "points";
  caption: string;
  at: number[];
  curves: Curve[];
}

/** Rows from the lowest Y on, cells from the lowest X on. */
export interface Mapped {
  title: string;
  unit: string;
  caption: string;
  ends_mm: [[number, number], [number, number]];
  rows: (number | null)[][];
}

export interface Shown {
  title: string;
  summary: string[];
  notes: string[];
  tables: { caption: string; header: string[]; rows: Cell[][] }[];
  plots: Plotted[];
  map: Mapped | null;
}

export interface Evaluated {
  shown: Shown;
  becomes: Becomes | null;
  notes: string[];
}
