// The module's description of a machine: desk/wasm/src/shown.rs.

import type { Shown as Described, Table as DescribedTable } from "../core/shown-types";

export interface Column {
  name: string;
  /** 0 to 5 for EX to EC; null: the position. */
  component: number | null;
  forward: boolean;
  reverse: boolean;
}

export interface Table {
  file: string;
  columns: Column[];
  /** In the units of the file, in the order of the columns. */
  rows: number[][];
}

export interface Axis {
  axis: string;
  unit: "mm" | "deg";
  micro: "um" | "urad";
  backlash: number;
  expansion: number;
  interpolation: "linear" | "cubic";
  max_feed_per_min: number;
  table?: Table;
  correction?: { rate: number; rate_limit: number; moving: string; acceleration: number | null; acceleration_limit: number };
}

/** Errors over two or three axes: desk/wasm/src/shown.rs. */
export interface Grid {
  nodes_mm: [number[], number[], number[]];
  given: boolean[];
  /** µm and µrad. */
  micro: number[][];
  fade_mm: [number, number] | null;
}

export interface Margins {
  axis: string;
  phase_margin_deg: number | null;
  gain_margin_db: number | null;
  largest_proportional: number | null;
  largest_integral_per_s: number | null;
}

export interface AxisSummary {
  axis: string;
  unit: string;
  magnitude_micro: number;
  slope_per_s: number;
  acceleration_per_s2: number;
  table: { errors: { name: string; unit: string; max_abs: number }[] } | null;
}

export interface Summary {
  name: string;
  chain: string;
  machine_id: number;
  crc: number;
  model: "nine" | "volumetric";
  squareness_urad: [number, number, number];
  inverse_passes: number;
  memory_scalars: number;
  axes: AxisSummary[];
}

export interface Shown {
  notes: string[];
  check: { warnings: string[]; lost_motion: Record<string, number | string>[]; feedback_margins: Margins[]; summary: Summary };
  reference_temperature_c: number;
  axes: Axis[];
  grids: Grid[];
  measurements: { file: string; figures?: Described; refused?: string }[];
  /** The tables' own figures after ISO 230-2. */
  accuracy: DescribedTable;
}

/** A change in the format of `machine_change`. */
export type Change =
  | { change: "point"; axis: string; column: string; row: number; value: number; also?: [string, number][] }
  | { change: "insert"; axis: string; position: number }
  | { change: "remove"; axis: string; row: number }
  | { change: "key"; key: string; value: number | string };

const LETTERS = "XYZABC";
const MOVES = ["in X", "in Y", "in Z", "about X", "about Y", "about Z"];

/** `EYX`. */
export function errorName(axis: string, component: number): string {
  return `E${LETTERS[component]}${axis}`;
}

/** `EYX, straightness in Y`. */
export function errorTitle(axis: string, component: number): string {
  const rotary = LETTERS.indexOf(axis) >= 3;
  const [shift, turn] = rotary ? ["displacement", "tilt"] : ["straightness", "rotation"];
  const what = LETTERS[component] === axis ? "positioning" : `${component < 3 ? shift : turn} ${MOVES[component]}`;
  return `${errorName(axis, component)}, ${what}`;
}

/** Unit of an error as people write it. */
export function micro(unit: string): string {
  return unit === "um" ? "µm" : "µrad";
}

/** Unit of a position as people write it. */
export function length(unit: string): string {
  return unit === "deg" ? "°" : unit;
}
