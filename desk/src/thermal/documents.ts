// The module's response: the command line's document, drifts of held-out cycles, the texts.

interface Curve {
  of: string;
  knots: number[];
  offset_um: number[];
  offset_error_um: number[];
  slope: number[];
  slope_error: number[];
}

export interface Fit {
  rows: number;
  reference_c: number;
  sensors: { name: string; lag_s: number }[];
  spindle_lag_s: number | null;
  axes: { axis: string; curves: Curve[]; rms_um: number; condition: number }[];
  left_out: { name: string; range: number; reason: string }[];
  unconfirmed: { rpm: number; cycle: number }[];
  predicted_um: [number, number];
  cycles: { axis: string; cycle: number; held_out: boolean; drift_um: number; left_um: number; drift_rms_um: number; left_rms_um: number }[];
  held_out_um: [number, number];
}

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
  document: Fit;
  drifts: Drift[];
  toml: string;
  notes: string[];
}
