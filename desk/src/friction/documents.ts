// The module's responses: tables and curves.

import type { Shown } from "../core/shown-types";

export interface SpikeCurves {
  axis: string;
  acceleration_mm_per_s2: number;
  reversals: number;
  time_ms: number[];
  before_um: number[];
  predicted_um: number[];
  after_um: number[];
}

export interface CircleCurves {
  radius_mm: number;
  feed_mm_per_min: number;
  counterclockwise: boolean;
  turns: number;
  angle_deg: number[];
  before_um: number[];
  predicted_um: number[];
  after_um: number[];
}

export interface Curves {
  spikes: SpikeCurves[];
  circles: CircleCurves[];
}

export interface Found extends Curves {
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

export interface Closed {
  /** Present if the record was simulated. */
  shown: Shown | null;
  before: Curves;
  after: Curves;
}
