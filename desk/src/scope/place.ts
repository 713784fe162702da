// Position of the tool: the path in three dimensions, coloured by contour error.

import { choice, el } from "../core/dom";
import { fixed } from "../core/number";
import { Scene, colourBar } from "../core/scene";
import type { Vector } from "../core/space";
import { KINDS, type Kind } from "./documents";
import type { Rows } from "./rows";

export class Place {
  readonly root: HTMLElement;
  private readonly scene: Scene;
  private readonly which;
  private readonly largest: (text: string) => void;
  private readonly said: HTMLElement;
  /** x, y, z of the programmed path, and the program line of each point. */
  private path = new Float32Array();
  private lines = new Float32Array();
  private rows: Rows | undefined;
  private row = 0;
  private low: Vector = [0, 0, 0];
  private high: Vector = [1, 1, 1];

  constructor() {
    const box = el("div");
    this.scene = new Scene(box, { label: "Path of the tool in the machine, coloured by contour error", height: 250 });
    this.which = choice<Kind>("Coloured by", [["compensated", KINDS.compensated.text]], "compensated", () => this.draw());
    this.said = el("output", { class: "readout" });
    const bar = el("div");
    this.largest = colourBar(bar, "contour error");
    this.root = el("div", { class: "place" }, box, el("div", { class: "row inline" }, this.which.root, bar), this.said);
  }

  /** Sets another run; the path in rows of x, y, z, line, cutting. */
  open(path: Float32Array, kinds: readonly Kind[]): void {
    const count = Math.floor(path.length / 5);
    this.path = Float32Array.from({ length: 3 * count }, (_, i) => path[5 * Math.floor(i / 3) + (i % 3)]!);
    this.lines = Float32Array.from({ length: count }, (_, i) => path[5 * i + 3]!);
    const now = this.which.value;
    this.which.select.replaceChildren(...kinds.map((kind) => el("option", { value: kind }, KINDS[kind].text)));
    this.which.value = kinds.includes(now) ? now : "compensated";
    [this.low, this.high] = corners(this.path);
    this.scene.fit(...nearer(this.low, this.high));
    this.rows = undefined;
    this.draw();
  }

  set(rows: Rows, row: number): void {
    [this.rows, this.row] = [rows, row];
    this.draw();
  }

  /** Moves the tool to a row. */
  show(row: number): void {
    if (row === this.row) return;
    this.row = row;
    this.draw();
  }

  /** Marks the position of a program line, whether it has run or not. */
  line(line: number): void {
    const first = this.lines.indexOf(line);
    if (first < 0) return;
    this.draw();
    const places = this.path.subarray(3 * first, 3 * (this.lines.lastIndexOf(line) + 1));
    this.scene.points(places, "warning", 6);
    this.said.textContent = `line ${line} on the path`;
  }

  private draw(): void {
    const { scene, rows } = this;
    scene.clear();
    scene.box(this.low, this.high);
    // Draws only the remaining path: under the completed part it would flicker.
    const reached = rows && rows.count > 0 ? Math.max(0, this.lines.lastIndexOf(rows.at(rows.count - 1, "line"))) : 0;
    scene.polyline(this.path.subarray(3 * reached), "servo");
    if (rows && rows.count > 0) {
      const places = new Float32Array(3 * rows.count);
      for (const [k, name] of ["x_mm", "y_mm", "z_mm"].entries()) {
        const column = rows.column(name);
        for (let row = 0; row < rows.count; row++) places[3 * row + k] = column[row]!;
      }
      const errors = rows.column(`${this.which.value}.error_um`);
      let most = 0;
      for (const error of errors) if (error > most) most = error;
      scene.polyline(places, "after", errors.map((error) => (most > 0 && error > 0 ? error / most : 0)));
      this.largest(most > 0 ? `${fixed(most, 2)} µm` : "–");
      this.tool(places.subarray(3 * this.row, 3 * this.row + 3), rows);
    }
    scene.draw();
  }

  private tool(at: Float32Array, rows: Rows): void {
    if (at.length < 3) return;
    const [x, y, z] = at as unknown as Vector;
    const height = 0.18 * Math.hypot(this.high[0] - this.low[0], this.high[1] - this.low[1]);
    this.scene.lines(new Float32Array([x, y, z, x, y, z + height]), "warning");
    this.scene.points(new Float32Array([x, y, z]), "warning", 9);
    this.said.textContent = `X ${fixed(x, 3)}  Y ${fixed(y, 3)}  Z ${fixed(z, 3)} mm, ${fixed(rows.at(this.row, "time_s"), 4)} s, line ${rows.at(this.row, "line")}`;
  }
}

/** Smallest box around a path that shows something along every axis. */
function corners(path: Float32Array): [Vector, Vector] {
  const [low, high]: [Vector, Vector] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let i = 0; i < path.length; i++) {
    if (!Number.isFinite(path[i]!)) continue;
    low[i % 3] = Math.min(low[i % 3]!, path[i]!);
    high[i % 3] = Math.max(high[i % 3]!, path[i]!);
  }
  if (!Number.isFinite(low[0])) return [[0, 0, 0], [1, 1, 1]];
  const reach = 0.05 * Math.max(1, ...[0, 1, 2].map((k) => high[k]! - low[k]!));
  return [low.map((value, k) => Math.min(value, high[k]! - reach)) as Vector, high];
}

/** A smaller box: the picture fits a sphere around the box, but most paths are flat and leave its top and bottom empty. */
function nearer(low: Vector, high: Vector): [Vector, Vector] {
  const toward = (share: number) => low.map((value, k) => value + share * (high[k]! - value)) as Vector;
  return [toward(0.07), toward(0.93)];
}
