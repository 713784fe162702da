// Thinned traces of a run: rows of named columns.

export class Rows {
  readonly count: number;
  private readonly kept = new Map<string, Float64Array>();

  constructor(
    readonly columns: readonly string[],
    private readonly data: Float64Array,
  ) {
    this.count = columns.length > 0 ? Math.floor(data.length / columns.length) : 0;
  }

  has(name: string): boolean {
    return this.columns.includes(name);
  }

  /** One column; NaN throughout if no column has that name. */
  column(name: string): Float64Array {
    const kept = this.kept.get(name);
    if (kept) return kept;
    const at = this.columns.indexOf(name);
    const values = new Float64Array(this.count).fill(NaN);
    const width = this.columns.length;
    if (at >= 0) for (let row = 0; row < this.count; row++) values[row] = this.data[row * width + at]!;
    this.kept.set(name, values);
    return values;
  }

  /** One column for a plot: null if the module returns no value. */
  curve(name: string): (number | null)[] {
    return Array.from(this.column(name), (value) => (Number.isFinite(value) ? value : null));
  }

  at(row: number, name: string): number {
    return this.column(name)[row] ?? NaN;
  }

  /** The first row of a program line. */
  ofLine(line: number): number | undefined {
    const found = this.column("line").findIndex((value) => value === line);
    return found < 0 ? undefined : found;
  }
}

/** The nearest row for each position: `of` and `at` increase. */
export function nearest(of: Float64Array, at: Float64Array): Int32Array {
  let row = 0;
  return Int32Array.from(at, (wanted) => {
    while (row + 1 < of.length && Math.abs(of[row + 1]! - wanted) <= Math.abs(of[row]! - wanted)) row++;
    // No row to compare beyond the last one.
    const last = of[of.length - 1] ?? -Infinity;
    return wanted > last * (1 + 1e-9) + 1e-9 ? -1 : row;
  });
}
