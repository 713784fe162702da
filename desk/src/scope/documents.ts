// The module's responses about a run.

export interface BuiltIn {
  name: string;
  description: string;
}

export interface Limits {
  /** µm; rotary axes µrad. */
  magnitude: number;
}

export interface Axis {
  axis: string;
  rotary: boolean;
  unit: string;
  limits: Limits;
  dynamic_limits?: Limits | null;
}

export interface Description {
  machine: string;
  chain: string;
  program: string;
  cycles: number;
  period_s: number;
  /** The machines that run side by side. */
  kinds: Kind[];
  axes: Axis[];
  lines: string[];
  notes: string[];
}

export type Kind = "uncompensated" | "compensated" | "servo_only" | "full";

export interface Progress {
  cycle: number;
  cycles: number;
  time_s: number;
  done: boolean;
}

export interface Size {
  max: number;
  rms: number;
}

export interface FaultSpan {
  time_s: number;
  fault: string;
  axis: string;
  line: number;
  cycles: number;
}

/** A part of the document of `firmware-sim run --json`. */
export interface Figures {
  contour_error_um: Partial<Record<Kind, Size>>;
  orientation_error_urad?: Partial<Record<Kind, Size>>;
  faults: FaultSpan[];
  limited_cycles: number;
  stopped: boolean;
  digest: Partial<Record<Kind, string>>;
  /** Remarks, such as parts that the watch withdrew. */
  notes: string[];
}

export interface Recorded {
  act: string;
  time_s: number;
}

export interface Scenario {
  toml: string;
  command: string;
  /** Everything that the command reads, by its path. */
  files: Record<string, string>;
}

/** Labels of the runs, by their names in the figures. */
export const KINDS: Record<Kind, { text: string; colour: "before" | "after" | "servo" | "full"; dash?: number[] }> = {
  uncompensated: { text: "uncorrected", colour: "before" },
  compensated: { text: "corrected", colour: "after" },
  servo_only: { text: "servo alone", colour: "servo", dash: [6, 3] },
  full: { text: "everything on", colour: "full" },
};
