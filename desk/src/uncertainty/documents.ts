// The module's response: tables and a distribution.

import type { Shown } from "../core/shown-types";

export interface Known {
  shown: Shown;
  /** The point with the largest radius, and that radius by derivatives, µm. */
  worst: [place: string, radius_um: number];
  distances_um: number[];
  notes: string[];
}

export interface Request {
  at: number[];
  points: number;
  confidence_percent: number;
  trials: number;
  seed: number;
}
