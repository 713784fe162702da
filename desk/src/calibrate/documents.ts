// The module's responses: the command line's documents, curves, the corrected machine.

import type { Becomes } from "../core/becomes";
import type { Shown } from "../core/shown-types";

/** A term, with bounds if it may only change within them. */
export interface Expected {
  name: string;
  standard_error: number;
  unit: string;
  largest_update?: number;
  largest_total?: number;
}

export interface Foreseen {
  machine: string;
  program: string;
  touches: number;
  minutes: number;
  terms: Expected[];
  rank?: number;
  condition?: number;
  warnings?: string[];
}

export interface Planned {
  foreseen: Foreseen;
  program: string;
  notes: string[];
}

export interface Found {
  shown: Shown;
  machine: string;
  touches: number;
  residuals: { residual_um: number[]; sigma_um: number; visits: [number, string][] };
  becomes: Becomes;
  notes: string[];
}
