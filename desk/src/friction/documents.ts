// The module's responses: the command lines' documents, and curves.

export interface Friction<T> {
  coulomb_mm_per_s: T;
  presliding_um: T;
  stribeck_share: T;
  stribeck_velocity_mm_per_s: T;
  viscous: T;
}

export interface Drive<T> {
  position_gain_per_s: T;
  velocity_gain_per_s: T;
  reset_time_s: T;
  velocity_feed_forward: T;
  dead_time_s: T;
}

export interface Size {
  max: number;
  rms: number;
}

export interface AxisFound {
  axis: string;
  friction: Friction<number>;
  drive: Drive<number>;
  drive_found: boolean;
  standard_errors: Friction<number | null> & Drive<number | null>;
  reading_lag_s: number;
  glitch_um: { before: Size; predicted: Size; after: Size };
  explained: number;
  residual_um: number;
  fitted: number;
  condition: number;
  reversals: number;
}

export interface FrictionDocument {
  samples: number;
  period_s: number;
  axes: AxisFound[];
  warnings: string[];
}

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
  document: FrictionDocument;
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

type TrueFigures = Omit<Friction<number> & Drive<number>, "dead_time_s">;

/** The document of `firmware-sim friction --json`. */
export interface Outcome {
  cycles: number;
  axes: {
    axis: string;
    identified: TrueFigures;
    true: TrueFigures;
    glitch_um: { before: Size; predicted: Size; expected: Size; after: Size };
  }[];
  contour_error_um: { before: Size; after: Size };
}

export interface Closed {
  /** Present if the record was simulated. */
  outcome: Outcome | null;
  before: Curves;
  after: Curves;
}
