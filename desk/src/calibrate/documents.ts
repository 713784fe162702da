// The module's responses: the command line's documents, curves, the corrected machine.

import type { Becomes } from "../core/becomes";
import type { Shown, Table } from "../core/shown-types";

export interface Foreseen {
  machine: string;
  program: string;
  touches: number;
  minutes: number;
  rank?: number;
  condition?: number;
  warnings?: string[];
}

export interface Planned {
  foreseen: Foreseen;
  expected: Table;
  program: string;
  /** The program is the sheet for a dial's readings. */
  is_sheet?: boolean;
  notes: string[];
}

/** A rehearsed log, and the true errors of the machine that was drawn for it. */
export interface Rehearsed {
  log: string;
  truth: Table;
}

export interface Found {
  shown: Shown;
  machine: string;
  touches: number;
  residuals: { residual_um: number[]; sigma_um: number; visits: [number, string][] };
  becomes: Becomes;
  notes: string[];
}
