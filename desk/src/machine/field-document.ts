// Request for a field, and the module's response. Errors are actual − ideal, in machine directions.

export type Model = "nine" | "volumetric";
export type Triple = [number, number, number];

/** The module's `Settings`. */
export interface Request {
  points: number;
  kelvin: number;
  model?: Model;
  negative: string;
  tool_mm?: Triple;
  pose_deg: Record<string, number>;
}

export interface Cause {
  table: string;
  term: string;
  error_um: Triple;
  along_um: number;
}

export interface Worst {
  at_mm: Triple;
  error_um: Triple;
  size_um: number;
  orientation_urad: Triple;
  correction: number[];
  tables: { source: string; error_um: Triple; along_um: number }[];
  terms: Cause[];
  rest_um: Triple;
}

export interface Case {
  largest_um: number;
  rms_um: number;
  p95_um: number;
  range_um: [number, number][];
  orientation: { largest_urad: number; rms_urad: number };
  slices: { at_mm: number; largest_um: number }[][];
  worst: Worst;
}

export interface Left {
  after: Case | null;
  limited_points: number;
  refused: string | null;
}

export interface Figures {
  machine: string;
  chain: string;
  model: Model;
  own_model: Model;
  points: Triple;
  range_mm: [number, number][];
  temperature_c: number;
  kelvin: number;
  negative: string[];
  tool_mm: Triple;
  pose_deg: Record<string, number>;
  travel_deg: Record<string, [number, number]>;
  corrects_orientation: boolean;
  clamped_points: number;
  before: Case;
  nine: Left;
  volumetric: Left;
}

/** Which half of a row: the error before or after the correction. */
export type Half = "before" | "after";

/** The rows of the module: x, y, z, mm; error before; after, µm; X changes fastest. */
export class Rows {
  readonly count: number;
  private readonly sizes: Record<Half, Float32Array>;

  constructor(readonly all: Float32Array) {
    this.count = all.length / 9;
    this.sizes = { before: this.size(3), after: this.size(6) };
  }

  /** Three numbers per point: position, error before, error after. */
  columns(from: 0 | 3 | 6): Float32Array {
    const found = new Float32Array(3 * this.count);
    for (let i = 0; i < this.count; i++) found.set(this.all.subarray(9 * i + from, 9 * i + from + 3), 3 * i);
    return found;
  }

  /** Size of the error at every point, µm. */
  sizesOf(half: Half): Float32Array {
    return this.sizes[half];
  }

  largest(half: Half): number {
    return this.sizes[half].reduce((largest, size) => Math.max(largest, size), 0);
  }

  private size(from: number): Float32Array {
    return Float32Array.from({ length: this.count }, (_, i) => Math.hypot(this.all[9 * i + from]!, this.all[9 * i + from + 1]!, this.all[9 * i + from + 2]!));
  }
}

export const modelName: Record<Model, string> = { nine: "nine terms", volumetric: "volumetric" };

/** A place, mm, without zeros at its end. */
export function millimetres(mm: number): string {
  return String(Number(mm.toPrecision(6))).replace("-", "−");
}
