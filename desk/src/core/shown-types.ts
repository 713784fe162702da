// Generated from crates/trueaxis-evaluation/src/shown:
// TRUEAXIS_WRITE_TYPES=1 cargo test -p trueaxis-evaluation --test evaluation shown_types

/** Everything shown of a result. */
export interface Shown {
  /** Name of the test. */
  title: string;
  /** How the result was obtained, in parts. */
  summary: string[];
  /** The most important figure in a sentence, or "". */
  result: string;
  /** Remarks on the result, a sentence each. */
  notes: string[];
  /** Tables, the most important first. */
  tables: Table[];
  /** Plots in their order. */
  plots: Plot[];
  /** Polar plots, after the others. */
  polars: Polar[];
  /** A map, after all plots. */
  map: Map | null;
}

/** A table; the first cell of every row is its name. */
export interface Table {
  /** Caption of the table. */
  caption: string;
  /** Column headings. */
  header: string[];
  /** Rows, a cell for every heading. */
  rows: Cell[][];
  /** Column of percentages that are also drawn as bars. */
  bars: number | null;
}

/** A cell of a table. */
export type Cell = string | { text: string; value: number };

/** How curves are drawn. */
export type Look = "line" | "dotted" | "points" | "columns";

/** Curves over one column of positions. */
export interface Plot {
  /** Heading of the part of the page that contains the plot. */
  section: string;
  /** Title of the plot. */
  title: string;
  /** Quantity of the horizontal axis, and its unit ("" for none). */
  x: [string, string];
  /** Quantity of the vertical axis, and its unit. */
  y: [string, string];
  /** How the curves are drawn. */
  look: Look;
  /** Whether the vertical axis is logarithmic. */
  logarithmic: boolean;
  /** A limit of the quantity, drawn across. */
  limit: number | null;
  /** Explanation for the reader. */
  caption: string;
  /** Positions, ascending. */
  at: number[];
  /** The curves. */
  curves: Curve[];
}

/** A curve of a [`Plot`]. */
export interface Curve {
  /** Name of the curve. */
  name: string;
  /** Index of the curve's colour, from 0. */
  colour: number;
  /** Whether the line is dashed, or a column hatched. */
  dashed: boolean;
  /** A value for every position; NaN (null) if missing. */
  values: (number | null)[];
  /** Expanded uncertainties, 95 %; NaN (null) if unknown at a position, empty if unknown everywhere. */
  expanded: (number | null)[];
}

/** Deviations of the radius over the angle of a circle. The desk draws all plots of a section to the same scale. */
export interface Polar {
  /** Heading of the part of the page that contains the plot. */
  section: string;
  /** Title of the plot. */
  title: string;
  /** Axes of the circle's plane; the first is at 0°. */
  axes: [string, string];
  /** The curves. */
  curves: Around[];
}

/** A curve of a [`Polar`]. */
export interface Around {
  /** Name of the curve. */
  name: string;
  /** Index of the curve's colour, from 0. */
  colour: number;
  /** Angles from the first axis toward the second, in the order of travel. */
  angle_deg: number[];
  /** Deviations, positive outward. */
  um: number[];
}

/** Values over the cells of a plane. */
export interface Map {
  /** Title of the map. */
  title: string;
  /** Unit of the values. */
  unit: string;
  /** Explanation for the reader. */
  caption: string;
  /** Lowest and highest X and Y, mm. */
  ends_mm: [[number, number], [number, number]];
  /** Rows from the lowest Y, cells from the lowest X; NaN (null) for a cell without a value. */
  rows: ((number | null)[])[];
}
