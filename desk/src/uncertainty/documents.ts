// The module's response: the command line's document and a distribution.

export interface Spread {
  standard_um: [number, number, number];
  factor: [number, number, number] | null;
  expanded_um: [number, number, number];
  radius_um: number;
}

export interface AtPoint {
  at: Record<string, number>;
  jacobian: Spread;
  monte_carlo: Spread;
  difference: number;
}

export interface Uncertainty {
  machine: string;
  confidence_percent: number;
  points: number;
  standard_rms_um: number;
  worst: AtPoint;
  at?: AtPoint;
  contributions: { term: string; rms_um: number; share: number; worst_um: number }[];
  not_stated: string[];
  trials: number;
  seed: number;
  warnings: string[];
}

export interface Known {
  document: Uncertainty;
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
