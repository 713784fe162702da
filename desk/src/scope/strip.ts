// Flags over time: one lane each, filled while the flag is set.

import uPlot from "uplot";
import { el, table, unique } from "../core/dom";
import type { Rows } from "./rows";
import { colour, onTheme, type ColourName } from "../core/theme";

export interface Lane {
  name: string;
  colour: ColourName;
  /** Raised if not zero. */
  values: ArrayLike<number>;
}

const LANE = 13;
const AXIS = 32;

export class Strip {
  readonly root: HTMLElement;
  private readonly area: HTMLElement;
  private readonly words: HTMLElement;
  private plot: uPlot | undefined;
  private time: ArrayLike<number> = [];
  private lanes: Lane[] = [];
  private marks: number[] = [];
  /** Whether the colours have changed while the strip was hidden. */
  private stale = false;

  constructor(
    host: HTMLElement,
    title: string,
    private readonly sync: string,
  ) {
    const id = unique("strip");
    this.area = el("div", { class: "plot", role: "img", "aria-labelledby": id });
    this.words = el("div", { class: "rows", tabindex: 0, role: "group", "aria-label": "Flags: stretches" });
    const table = el("details", { ontoggle: () => this.fill() }, el("summary", {}, "Table"), this.words);
    this.root = el("figure", { class: "strip" }, el("figcaption", { id }, title), this.area, table);
    host.append(this.root);
    new ResizeObserver(() => this.build()).observe(this.area);
    onTheme(this, (strip) => {
      strip.stale = true;
      strip.build(true);
    });
  }

  set(time: ArrayLike<number>, lanes: Lane[], marks: number[]): void {
    this.marks = marks;
    const same = lanes.length === this.lanes.length && lanes.every((lane, i) => lane.name === this.lanes[i]?.name);
    [this.time, this.lanes] = [time, lanes];
    if (same && this.plot && !this.stale) this.plot.setData(this.data());
    else this.build(true);
    if (this.root.querySelector("details")?.open) this.fill();
    const raised = this.stretches().map(([name, from, to]) => `${name} ${from} to ${to} s`);
    this.area.setAttribute("aria-description", raised.slice(0, 20).join("; ") || "none raised");
  }

  private data(): uPlot.AlignedData {
    return [this.time, ...this.lanes.map((lane) => lane.values)] as unknown as uPlot.AlignedData;
  }

  private build(rebuild = false): void {
    const width = this.area.clientWidth;
    if (width === 0 || this.lanes.length === 0) return;
    const height = this.lanes.length * LANE + AXIS + 14;
    if (this.plot && !rebuild && !this.stale) {
      if (Math.abs(this.plot.width - width) > 1) this.plot.setSize({ width, height });
      return;
    }
    this.plot?.destroy();
    this.stale = false;
    const count = this.lanes.length;
    const style = { stroke: colour("ink"), font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif" };
    this.plot = new uPlot(
      {
        width,
        height,
        cursor: { sync: { key: this.sync, setSeries: false }, drag: { x: true, y: false }, y: false, points: { show: false } },
        legend: { show: false },
        scales: { x: { time: false }, y: { range: [0, count] } },
        axes: [
          { ...style, label: "time / s", size: AXIS, labelSize: 16, grid: { stroke: colour("grid"), width: 1 }, ticks: { stroke: colour("grid"), width: 1 } },
          {
            ...style,
            // The width of the axes of the plots above.
            font: "10px system-ui, sans-serif",
            size: 74,
            splits: () => this.lanes.map((_, i) => count - i - 0.5),
            values: () => this.lanes.map((lane) => lane.name),
            grid: { show: false },
            ticks: { show: false },
          },
        ],
        series: [{}, ...this.lanes.map(() => ({ paths: () => null, points: { show: false } }))],
        hooks: { draw: [(plot) => this.draw(plot)] },
      },
      this.data(),
      this.area,
    );
  }

  private draw(plot: uPlot): void {
    const { ctx, bbox } = plot;
    const count = this.lanes.length;
    const height = bbox.height / count;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const [i, lane] of this.lanes.entries()) {
      const top = bbox.top + i * height;
      ctx.fillStyle = colour("grid");
      ctx.fillRect(bbox.left, top + height - 1, bbox.width, 1);
      ctx.fillStyle = colour(lane.colour);
      for (const [first, last] of runs(lane.values)) {
        const [from, to] = [plot.valToPos(this.time[first]!, "x", true), plot.valToPos(this.time[last]!, "x", true)];
        ctx.fillRect(from - devicePixelRatio, top + 2 * devicePixelRatio, Math.max(2 * devicePixelRatio, to - from), height - 4 * devicePixelRatio);
      }
    }
    ctx.strokeStyle = colour("ink");
    ctx.setLineDash([2 * devicePixelRatio, 3 * devicePixelRatio]);
    ctx.beginPath();
    for (const x of this.marks) {
      const at = plot.valToPos(x, "x", true);
      ctx.moveTo(at, bbox.top);
      ctx.lineTo(at, bbox.top + bbox.height);
    }
    ctx.stroke();
    ctx.restore();
  }

  private stretches(): [string, string, string][] {
    const s = (row: number) => this.time[row]!.toFixed(4);
    return this.lanes.flatMap((lane) => runs(lane.values).map(([first, last]) => [lane.name, s(first), s(last)] as [string, string, string]));
  }

  private fill(): void {
    const rows = this.stretches();
    this.words.replaceChildren(table("Flags, as thinned", ["flag", "from / s", "to / s"], rows.length > 0 ? rows : [["none raised", "", ""]]));
  }
}

/** Meaning of shaded stretches. */
export const RAPID = "rapid traverse, not counted in the figures";

/** Stretches of rapid traverse along a column. */
export function rapids(rows: Rows, along: ArrayLike<number>): [from: number, to: number][] {
  const found = runs(Array.from(rows.column("cutting"), (cutting) => (cutting === 0 ? 1 : 0)));
  // Up to the next row: a stretch of a single row would have no width.
  return found.map(([first, last]) => [along[first]!, along[Math.min(last + 1, rows.count - 1)]!]);
}

/** Intervals in which a flag is raised: first and last row. */
export function runs(values: ArrayLike<number>): [number, number][] {
  const found: [number, number][] = [];
  for (let row = 0; row < values.length; row++) {
    if (!(values[row]! > 0)) continue;
    const last = found[found.length - 1];
    if (last && last[1] === row - 1) last[1] = row;
    else found.push([row, row]);
  }
  return found;
}
