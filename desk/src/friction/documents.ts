// The module's responses: tables and plots.

import type { Shown } from "../core/shown-types";

export interface Found {
  shown: Shown;
  /** Largest spike of every axis, recorded and expected, µm. */
  largest: [axis: string, um: [number, number]][];
  /** Sections of a machine.toml. */
  settings: string;
}

export interface RecordRead {
  samples: number;
  period_s: number;
  notes: string[];
}

export interface Trace {
  time_s: number[];
  following_error_um: [number[], number[]];
}
