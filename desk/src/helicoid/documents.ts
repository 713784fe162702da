// The module's responses.

import type { Table } from "../core/shown-types";

export type AxisLetter = "X" | "Y" | "Z" | "A" | "C";
export const AXES = ["X", "Y", "Z", "A", "C"] as const;
export type Limits = Partial<Record<AxisLetter, [number, number] | null>>;

export interface Fit {
  machine: string;
  chain: string;
  fits: boolean;
  reasons: string[];
  travel: Limits | null;
}

export interface AxisReach {
  axis: AxisLetter;
  unit: "mm" | "degrees";
  low: number;
  high: number;
  limit: [number, number] | null;
  beyond: number;
}

export interface Reach {
  branch: number;
  axes: AxisReach[];
  beyond: number;
}

export interface Outline {
  inputs: { pivot_mm: number };
  surface: { base_radius_mm: number };
  /** Values derived from the gear or the base circle. */
  flank: Table;
  notes: string[];
  reach: [Reach, Reach];
  fit: Fit;
}

export interface Beyond {
  axis: AxisLetter;
  found: number;
  low: number;
  high: number;
}

export interface BranchPose {
  branch: number;
  x_mm: number;
  y_mm: number;
  z_mm: number;
  a_deg: number;
  c_deg: number;
  a_axis: [number, number, number];
  off_surface_um: number;
  off_normal_urad: number;
  beyond: Beyond[];
}

export interface Tool {
  u_rad: number;
  theta_rad: number;
  point_mm: [number, number, number];
  normal: [number, number, number];
  radius_mm: number;
  stands: [BranchPose, BranchPose];
  singular: { margin_deg: number; a_deg: number; gain: number; fade_deg: number; near: boolean };
}

export interface Errors {
  tip_um: number[];
  normal_um: number[];
  direction_urad: number[];
  largest: [number, number, number];
}

export interface Flanked {
  fit: Fit;
  parameter_rad: number[];
  before: Errors;
  after: Errors;
  out_of_travel: string[];
}
