// The module's response: tables, drifts of held-out cycles, the texts.

import type { Shown } from "../core/shown-types";

export interface Drift {
  axis: string;
  cycle: number;
  point_mm: [number, number, number, number];
  hours: number[];
  measured_um: number[];
  said_um: number[];
  left_um: number[];
}

export interface Fitted {
  shown: Shown;
  drifts: Drift[];
  toml: string;
  notes: string[];
}
