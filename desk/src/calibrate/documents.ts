// The module's responses: the command line's documents, curves, the corrected machine.

import type { Becomes } from "../core/becomes";

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

export interface Calibration {
  machine: string;
  touches: number;
  rank: number;
  condition: number;
  degrees_of_freedom: number;
  sigma_um: number;
  repeatability_um: number;
  signal_um: number;
  terms: (Expected & { value: number })[];
  tip_radius_mm: number;
  tip_radius_standard_error_um: number;
  artefacts: { name: string; stated: number; found: number; standard_error: number }[];
  drift: { time_s: number; um: [number, number, number] }[];
  warnings: string[];
}

export interface Curves {
  axis: string;
  position_mm: number[];
  error_um: [number[], number[], number[]];
  expanded_um: [number[], number[], number[]];
}

export interface Found {
  document: Calibration;
  residuals: { residual_um: number[]; sigma_um: number; visits: [number, string][] };
  curves: Curves[];
  becomes: Becomes;
  notes: string[];
}
