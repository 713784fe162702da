// The tool on the flank, in the gear's frame.

import type { Desk } from "../core/desk";
import { choice, el } from "../core/dom";
import { Scene } from "../core/scene";
import type { Vector } from "../core/space";
import type { Outline, Tool } from "./documents";
import { narrowed, request, type Inputs } from "./request";

const ROWS = 33;
const COLUMNS = 25;
/** Lines of u and of θ drawn on the flank. */
const GRID = 9;
/** Points along a line of the flank, and around the tool. */
const LINE = 60;
const ROUND = 20;

const along = (from: readonly number[], direction: readonly number[], distance: number): Vector =>
  [0, 1, 2].map((i) => from[i]! + distance * direction[i]!) as Vector;

export class Picture {
  readonly root: HTMLElement;
  private readonly scene: Scene;
  private readonly whole: { value: "flank" | "gear" };
  private mesh = new Float32Array();
  private around = new Float32Array();
  private size: [number, number] = [0, 0];
  private turned = false;
  private drawn: { inputs: Inputs; outline: Outline; tool: Tool } | undefined;

  constructor(private readonly desk: Desk) {
    const host = el("div");
    this.scene = new Scene(host, { label: "The flank with the tool along its outward normal", height: 430 });
    const shown = choice("Picture shows", [["flank", "the flank"], ["gear", "gear and head"]] as const, "flank", () => void this.again());
    this.whole = shown;
    const key = el("p", { class: "said" }, "Blue: flank. Orange: tool, from its tip to the A axis. Green: lines of u and θ through the tip. Grey: base circles, other teeth.");
    this.root = el("div", {}, el("div", { class: "row" }, shown.root), host, key);
  }

  /** Draws another flank. */
  async surface(inputs: Inputs): Promise<void> {
    const asked = request(inputs);
    this.size = [inputs.theta.count === 1 ? 1 : ROWS, inputs.u.count === 1 ? 1 : COLUMNS];
    [this.mesh, this.around] = (await Promise.all([
      this.desk.bench.call("helicoid_mesh", asked, ROWS, COLUMNS, 0),
      this.desk.bench.call("helicoid_surroundings", asked),
    ])) as [Float32Array<ArrayBuffer>, Float32Array<ArrayBuffer>];
  }

  /** Draws the tool at its place. */
  async tool(inputs: Inputs, outline: Outline, tool: Tool): Promise<void> {
    this.drawn = { inputs, outline, tool };
    const { u_rad: u, theta_rad: theta } = tool;
    const one = (value: number) => ({ start: value, stop: value, count: 1 });
    const { scene } = this;
    const [low, high] = this.bounds();
    const reach = Math.max(Math.hypot(...high.map((value, i) => value - low[i]!)) / 2, 0.05 * outline.surface.base_radius_mm);
    const lifts = [0.004 * reach, -0.004 * reach];
    const line = (at: string, rows: number, columns: number) => lifts.map((lift) => this.desk.bench.call("helicoid_mesh", at, rows, columns, lift));
    const [lines, ...grids] = await Promise.all([
      Promise.all([...line(narrowed(inputs, one(u), inputs.theta), LINE, 1), ...line(narrowed(inputs, inputs.u, one(theta)), 1, LINE)]),
      ...line(request(inputs), GRID, GRID),
    ]);
    if (this.drawn.tool !== tool) return;
    scene.clear();
    const pivot = outline.inputs.pivot_mm;
    const centre = tool.point_mm;
    if (this.whole.value === "flank") scene.fit(low.map((v) => v - 0.35 * reach) as Vector, high.map((v) => v + 0.35 * reach) as Vector);
    else {
      const end = along(centre, tool.normal, pivot);
      const outer = outline.surface.base_radius_mm * 1.2;
      scene.fit([Math.min(-outer, end[0]), Math.min(-outer, end[1]), Math.min(low[2], end[2])], [Math.max(outer, end[0]), Math.max(outer, end[1]), Math.max(high[2], end[2])]);
    }
    scene.mesh(this.mesh, this.size[0], this.size[1], "after");
    scene.lines(this.around, "servo");
    for (const grid of grids) this.net(grid as Float32Array);
    for (const one of lines!) scene.polyline(one as Float32Array, "full");
    if (!this.turned) {
      // Viewed from beside the tool, so that neither tool nor flank is seen end on.
      this.turned = true;
      scene.viewFrom(Math.atan2(tool.normal[1], tool.normal[0]) + 0.95, 0.5);
    }
    this.holder(centre, tool.normal, Math.max(pivot, 0.3 * reach), reach);
    const [axis, at] = [tool.stands[inputs.branch - 1]!.a_axis, along(centre, tool.normal, pivot)];
    scene.lines(new Float32Array([...along(at, axis, -0.5 * reach), ...along(at, axis, 0.5 * reach)]), "a");
    scene.label(along(at, axis, 0.55 * reach), "A");
    this.axes(0.55 * outline.surface.base_radius_mm);
    scene.points(new Float32Array(centre), "ink", 9);
    scene.label(along(centre, tool.normal, 0.16 * reach), "tip");
    scene.draw();
  }

  private async again(): Promise<void> {
    if (this.drawn) await this.tool(this.drawn.inputs, this.drawn.outline, this.drawn.tool);
  }

  private bounds(): [Vector, Vector] {
    const [low, high]: [Vector, Vector] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    for (let i = 0; i < this.mesh.length; i++) {
      low[i % 3] = Math.min(low[i % 3]!, this.mesh[i]!);
      high[i % 3] = Math.max(high[i % 3]!, this.mesh[i]!);
    }
    return [low, high];
  }

  /** Lines of u and of θ. */
  private net(points: Float32Array): void {
    const rows = this.size[0] === 1 ? 1 : GRID;
    const columns = this.size[1] === 1 ? 1 : GRID;
    const pairs: number[] = [];
    const pair = (i: number, k: number) => pairs.push(...points.subarray(3 * i, 3 * i + 3), ...points.subarray(3 * k, 3 * k + 3));
    for (let r = 0; r < rows; r++)
      for (let c = 0; c < columns; c++) {
        if (c + 1 < columns) pair(r * columns + c, r * columns + c + 1);
        if (r + 1 < rows) pair(r * columns + c, (r + 1) * columns + c);
      }
    this.scene.lines(new Float32Array(pairs), "grid");
  }

  /** A slender tool that widens to its holder, as a surface of revolution about the normal. */
  private holder(tip: Vector, normal: Vector, length: number, reach: number): void {
    const other: Vector = Math.abs(normal[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const cross = (p: Vector, q: Vector): Vector => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    const across = cross(normal, other);
    const size = Math.hypot(...across);
    const p = across.map((value) => value / size) as Vector;
    const q = cross(normal, p);
    const thin = 0.03 * reach;
    const rings: [number, number][] = [[0, 0], [0.08 * reach, thin], [0.7 * reach, thin], [0.75 * reach, 2.5 * thin], [length, 2.5 * thin], [length, 0]];
    const points: number[] = [];
    for (const [distance, radius] of rings)
      for (let k = 0; k <= ROUND; k++) {
        const [c, s] = [radius * Math.cos((2 * Math.PI * k) / ROUND), radius * Math.sin((2 * Math.PI * k) / ROUND)];
        const centre = along(tip, normal, distance);
        points.push(...centre.map((value, i) => value + c * p[i]! + s * q[i]!));
      }
    this.scene.mesh(new Float32Array(points), rings.length, ROUND + 1, "before");
  }

  /** x, y and z of the gear at its origin. */
  private axes(length: number): void {
    for (const [i, name] of (["x", "y", "z"] as const).entries()) {
      const end: Vector = [0, 0, 0];
      end[i] = length;
      this.scene.lines(new Float32Array([0, 0, 0, ...end]), name);
      this.scene.label(end, name);
    }
  }
}
