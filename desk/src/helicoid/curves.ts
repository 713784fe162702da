// Five displacements along a line of the flank, on both branches.

import { el } from "../core/dom";
import { Plot, type Series } from "../core/plot";
import type { Desk } from "../core/desk";
import { AXES, type AxisLetter, type Limits } from "./documents";
import { request, type Inputs } from "./request";

/** Points of a line. */
export const POINTS = 201;
export type Line = "theta" | "u";
const SYNC = "helicoid";

type Column = Float64Array;

export class Curves {
  readonly root = el("div");
  private plots: [Plot, Plot] | undefined;
  private line: Line | undefined;
  private parameter: Column = new Float64Array();

  constructor(
    private readonly desk: Desk,
    /** Receives the cursor's new position. */
    private readonly moved: (parameter: number) => void,
  ) {}

  /** The line through (u, θ): along one parameter, the other held. */
  async set(inputs: Inputs, limits: Limits, line: Line, held: number): Promise<void> {
    const columns = await this.desk.bench.call("helicoid_curve", request(inputs), line, held, POINTS);
    const length = columns.length / 11;
    const column = (i: number) => columns.subarray(i * length, (i + 1) * length);
    this.parameter = column(0);
    const [lengths, angles] = this.build(line);
    lengths.set([this.parameter, ...[1, 2, 3, 6, 7, 8].map(column)]);
    angles.set([this.parameter, ...[4, 5, 9, 10].map(column)]);
    const first = inputs.branch === 1 ? 1 : 6;
    const marks = (letters: readonly AxisLetter[]) => letters.flatMap((letter) => this.crossings(letter, column(first + AXES.indexOf(letter)), limits));
    lengths.mark(marks(["X", "Y", "Z"]));
    angles.mark(marks(["A", "C"]));
  }

  /** Moves the cursor to a parameter without reporting it. */
  show(parameter: number): void {
    if (this.parameter.length === 0 || !this.plots) return;
    let nearest = 0;
    for (const [i, value] of this.parameter.entries()) if (Math.abs(value - parameter) < Math.abs(this.parameter[nearest]! - parameter)) nearest = i;
    this.quiet = nearest;
    this.plots[0].show(nearest);
  }

  private quiet: number | null = null;

  private cursor(index: number | null): void {
    if (index === null || index === this.quiet) return;
    this.quiet = index;
    const value = this.parameter[index];
    if (value !== undefined) this.moved(value);
  }

  /** The parameters at which an axis reaches the end of its travel. */
  private crossings(letter: AxisLetter, column: Column, limits: Limits): { x: number; text: string }[] {
    const limit = limits[letter];
    if (!limit) return [];
    const outside = (i: number) => column[i]! < limit[0] || column[i]! > limit[1];
    const found: { x: number; text: string }[] = [];
    for (let i = 0; i < column.length; i++) {
      const now = outside(i);
      if (i === 0 ? now : now !== outside(i - 1)) found.push({ x: this.parameter[i]!, text: now ? `${letter} beyond its travel` : `${letter} within` });
    }
    return found;
  }

  private build(line: Line): [Plot, Plot] {
    if (this.plots && this.line === line) return this.plots;
    this.line = line;
    const x = line === "theta" ? "θ / rad" : "u / rad";
    const both = (letters: readonly (readonly [AxisLetter, Series["colour"]])[]): Series[] => [
      ...letters.map(([letter, colour]): Series => ({ name: `${letter}, branch 1`, colour, width: 1.8 })),
      ...letters.map(([letter, colour]): Series => ({ name: `${letter}, branch 2`, colour, dash: [6, 4] })),
    ];
    this.root.replaceChildren();
    // One plot reports the cursor's position: plots with the same key move with it.
    const plot = (title: string, y: string, series: Series[], onCursor?: (index: number | null) => void) =>
      new Plot(this.root, { title, x, y, series, sync: SYNC, height: 190, digits: 8, ...(onCursor ? { onCursor } : {}) });
    this.plots = [
      plot(`Linear axes over ${line === "theta" ? "θ" : "u"}`, "position / mm", both([["X", "x"], ["Y", "y"], ["Z", "z"]]), (index) => this.cursor(index)),
      plot(`Rotary axes over ${line === "theta" ? "θ" : "u"}`, "angle / degrees", both([["A", "a"], ["C", "c"]])),
    ];
    return this.plots;
  }
}
