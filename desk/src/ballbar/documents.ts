// The module's response: tables and curves.

import type { Shown } from "../core/shown-types";

export interface Trace {
  counterclockwise: boolean;
  angle_deg: number[];
  deviation_um: number[];
  left_um: number[];
}

export interface Evaluated {
  shown: Shown;
  /** Its two letters. */
  plane: string;
  traces: Trace[];
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
