// The module's response: tables and plots.

import type { Shown } from "../core/shown-types";

export interface Evaluated {
  shown: Shown;
  notes: string[];
}

export type Axes = "X,Y" | "Z,X" | "Y,Z" | "Y,X" | "X,Z" | "Z,Y";

/** Settings that the record does not contain. */
export interface Request {
  radius_mm: number;
  axes: Axes;
  /** Pitches of X, Y, Z; null: searched. */
  pitches_mm: [number | null, number | null, number | null];
}
