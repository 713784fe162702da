// The module's response: the command line's document, and curves.

export interface Ways {
  ccw: number | null;
  cw: number | null;
}

export interface Ballbar {
  readings: number;
  radius_mm: number;
  plane: string;
  g_b_um: number | null;
  g_um: Ways;
  f_um: Ways;
  f_max_um: Ways;
  f_min_um: Ways;
  h_um: number | null;
  radius_deviation_um: number;
  centre_um: [number, number];
  shares: { cause: string; rms_um: number; share: number }[];
  sigma_um: number;
  degrees_of_freedom: number;
  condition: number;
  warnings: string[];
}

export interface Trace {
  counterclockwise: boolean;
  angle_deg: number[];
  deviation_um: number[];
  left_um: number[];
}

export interface Evaluated {
  document: Ballbar;
  /** Name, value, half of the interval of 95 %. */
  values: [string, string, string][];
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
