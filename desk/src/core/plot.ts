// Curves over a common axis: uPlot with a data table behind it, a keyboard-controlled cursor, and both themes.

import uPlot from "uplot";
import { button, el, unique } from "./dom";
import { save } from "./files";
import { significant } from "./number";
import { colour, onTheme, type ColourName } from "./theme";

export interface Series {
  name: string;
  colour: ColourName;
  /** Dashes, in px, so that curves are distinguishable without colour. */
  dash?: number[];
  /** Points instead of a line. */
  points?: boolean;
  /** A line with a point at every value. */
  dots?: boolean;
  /** Bars instead of a line; hatched ones are distinguishable without colour. */
  bars?: "solid" | "hatched";
  width?: number;
  /** Unit, if it differs from that of the axis. */
  unit?: string;
  /** Connects the line across missing values. */
  joined?: boolean;
}

/** A curve and the lines of its expanded uncertainty, 95 %, to either side of it: series and columns. */
export function withBand(series: Series, values: readonly number[], expanded: readonly number[]): { series: Series[]; columns: number[][] } {
  const edge = (name: string): Series => ({ ...series, name: `${series.name} ${name}`, dash: [1, 4], width: 0.8, dots: false });
  return { series: [series, edge("+ 95 %"), edge("− 95 %")], columns: [0, 1, -1].map((factor) => values.map((value, i) => value + factor * expanded[i]!)) };
}

export interface PlotOptions {
  title: string;
  x: string;
  y: string;
  series: Series[];
  /** Plots of one key move their cursors together. */
  sync?: string;
  height?: number;
  /** Receives the position of the cursor; null if it is outside the plot. */
  onCursor?: (index: number | null) => void;
  /** Significant digits of the readout. */
  digits?: number;
  /** Fixed ends of the vertical axis. */
  range?: [number, number];
  /** A logarithmic vertical axis. */
  logarithmic?: boolean;
  /** Shown in place of a plot without values: what will be there. */
  empty?: string;
  /** Meaning of the shaded stretches. */
  shaded?: string;
}

type Column = ArrayLike<number | null>;

/** Rows of the table behind a plot; the CSV has them all. */
const TABLE_ROWS = 500;

/** Plots whose cursors move together, by key. */
const groups = new Map<string, Plot[]>();

export class Plot {
  readonly root: HTMLElement;
  private readonly area: HTMLElement;
  private readonly empty: HTMLElement;
  private readonly key: HTMLElement;
  private readonly readout: HTMLElement;
  private readonly rows: HTMLElement;
  private readonly details: HTMLDetailsElement;
  private plot: uPlot | undefined;
  private data: Column[] = [];
  private marks: { x: number; text: string }[] = [];
  private shaded: [from: number, to: number][] = [];
  private cursor: number | null = null;
  /** Whether the colours have changed while the plot was hidden. */
  private stale = false;

  constructor(
    host: HTMLElement,
    private readonly options: PlotOptions,
  ) {
    const id = unique("plot");
    this.area = el("div", { class: "plot", tabindex: 0, role: "img", "aria-labelledby": id, hidden: true, onkeydown: (event: KeyboardEvent) => this.pressed(event) });
    this.empty = el("p", { class: "empty", style: `min-height:${options.height ?? 200}px` }, options.empty ?? "No values yet.");
    this.key = el("small", { class: "shaded", hidden: true }, options.shaded ?? "");
    this.readout = el("output", { class: "readout", for: id });
    this.rows = el("div", { class: "rows", tabindex: 0, role: "group", "aria-label": `${options.title}: numbers` });
    this.details = el("details", { ontoggle: () => this.fill() }, el("summary", {}, "Table"), this.rows, button("Save CSV", () => this.csv()));
    this.root = el("figure", {}, el("figcaption", { id }, options.title), this.key, this.empty, this.area, this.readout, this.details);
    host.append(this.root);
    if (options.sync) groups.set(options.sync, [...(groups.get(options.sync) ?? []).filter(({ root }) => root.isConnected), this]);
    new ResizeObserver(() => this.resize()).observe(this.area);
    onTheme(this, (plot) => {
      plot.stale = true;
      plot.rebuild();
    });
  }

  /** Columns: the horizontal axis first, then one per series; null leaves a gap. */
  set(data: Column[]): void {
    this.data = data;
    this.area.hidden = !data[0]?.length;
    this.empty.hidden = !this.area.hidden;
    if (this.area.hidden) return;
    if (this.plot && !this.stale) this.plot.setData(this.aligned());
    else this.rebuild();
    this.describe();
    if (this.details.open) this.fill();
  }

  /** Vertical lines with a word each. */
  mark(marks: { x: number; text: string }[]): void {
    this.marks = marks;
    this.plot?.redraw(false);
  }

  /** Shades stretches of the horizontal axis. */
  shade(stretches: [from: number, to: number][]): void {
    this.shaded = stretches;
    this.key.hidden = stretches.length === 0 || this.options.shaded === undefined;
    this.plot?.redraw(false);
  }

  /** Moves the cursor to a point of the data. */
  show(index: number | null): void {
    const together = groups.get(this.options.sync ?? "") ?? [this];
    const length = this.data[0]?.length;
    for (const plot of together) if (plot.root.isConnected && plot.data[0]?.length === length) plot.moveCursor(index);
  }

  /** Places the cursor at exactly this row, even if several rows share a pixel. */
  private moveCursor(index: number | null): void {
    const x = index === null ? undefined : this.data[0]?.[index];
    if (this.plot && x !== null && x !== undefined) {
      // Not published to other plots: uPlot's types omit the last parameter.
      const move = this.plot.setCursor as (at: { left: number; top: number }, fire: boolean, publish: boolean) => void;
      move({ left: this.plot.valToPos(x, "x"), top: this.plot.over.clientHeight / 2 }, true, false);
    }
    if (this.cursor !== index) this.moved(index);
  }

  /** The underlying uPlot, for functions that only one view needs. */
  get inner(): uPlot | undefined {
    return this.plot;
  }

  private aligned(): uPlot.AlignedData {
    return this.data as unknown as uPlot.AlignedData;
  }

  private width(): number {
    return Math.max(200, this.area.clientWidth);
  }

  private resize(): void {
    if (!this.plot || this.stale) this.rebuild();
    else if (this.area.clientWidth > 0 && Math.abs(this.width() - this.plot.width) > 1)
      this.plot.setSize({ width: this.width(), height: this.options.height ?? 200 });
  }

  private rebuild(): void {
    if (this.data.length === 0 || this.area.clientWidth === 0) return;
    this.plot?.destroy();
    this.stale = false;
    const { options } = this;
    const axis = (label: string, size: number): uPlot.Axis => ({
      label,
      size,
      labelSize: 18,
      stroke: colour("ink"),
      grid: { stroke: colour("grid"), width: 1 },
      ticks: { stroke: colour("grid"), width: 1 },
      font: "12px system-ui, sans-serif",
      labelFont: "12px system-ui, sans-serif",
      values: (_plot, splits) => splits.map((value) => (value === null ? "" : String(Number(value.toPrecision(6))).replace("-", "−"))),
    });
    const config: uPlot.Options = {
      width: this.width(),
      height: options.height ?? 200,
      cursor: { ...(options.sync ? { sync: { key: options.sync, setSeries: false } } : {}), drag: { x: true, y: false } },
      legend: { show: true, live: false },
      scales: { x: { time: false, ...this.beyond() }, ...(options.range ? { y: { range: options.range } } : {}), ...(options.logarithmic ? { y: { distr: 3 } } : {}) },
      axes: [axis(options.x, 36), axis(options.y, 56)],
      series: [{ label: options.x }, ...options.series.map((one) => this.series(one))],
      hooks: {
        setCursor: [(plot) => this.moved(plot.cursor.idx ?? null)],
        drawClear: [(plot) => this.drawShades(plot)],
        draw: [(plot) => this.drawMarks(plot)],
      },
    };
    this.plot = new uPlot(config, this.aligned(), this.area);
    this.describe();
  }

  /** Room at both ends, so that bars and points are not clipped. */
  private beyond(): uPlot.Scale {
    const { series } = this.options;
    const room = (low: number, high: number) => (series.some((one) => one.bars) ? 0.6 : 0.02 * (high - low || 1));
    return series.some((one) => one.bars || one.points) ? { range: (_plot, low, high) => [low - room(low, high), high + room(low, high)] } : {};
  }

  private series(one: Series): uPlot.Series {
    return {
      label: one.name,
      stroke: colour(one.colour),
      width: one.points ? 0 : (one.width ?? 1.4),
      spanGaps: one.joined ?? false,
      ...(one.dash ? { dash: one.dash } : {}),
      points: { show: one.points ?? one.dots ?? false, size: 5, fill: colour(one.colour) },
      ...(one.bars ? { paths: uPlot.paths.bars!({ size: [0.76, 40] }), width: one.bars === "hatched" ? 1 : 0, fill: one.bars === "hatched" ? hatching(colour(one.colour)) : colour(one.colour) } : {}),
    };
  }

  private drawShades(plot: uPlot): void {
    const { ctx, bbox } = plot;
    ctx.fillStyle = colour("grid");
    for (const [from, to] of this.shaded) {
      const [left, right] = [from, to].map((x) => Math.min(bbox.left + bbox.width, Math.max(bbox.left, plot.valToPos(x, "x", true)))) as [number, number];
      if (right > left) ctx.fillRect(left, bbox.top, right - left, bbox.height);
    }
  }

  private drawMarks(plot: uPlot): void {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colour("ink");
    ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    ctx.setLineDash([2 * devicePixelRatio, 3 * devicePixelRatio]);
    for (const { x, text } of this.marks) {
      const at = plot.valToPos(x, "x", true);
      if (at < bbox.left || at > bbox.left + bbox.width) continue;
      ctx.beginPath();
      ctx.moveTo(at, bbox.top);
      ctx.lineTo(at, bbox.top + bbox.height);
      ctx.stroke();
      const fits = at + ctx.measureText(text).width + 6 * devicePixelRatio <= bbox.left + bbox.width;
      ctx.textAlign = fits ? "left" : "right";
      ctx.fillText(text, at + (fits ? 3 : -3) * devicePixelRatio, bbox.top + 11 * devicePixelRatio);
    }
    ctx.restore();
  }

  private moved(index: number | null): void {
    this.cursor = index;
    this.readout.textContent = index === null ? "" : this.words(index);
    this.options.onCursor?.(index);
  }

  /** The values at a point, in words. */
  private words(index: number): string {
    const digits = this.options.digits ?? 4;
    const number = (column: Column | undefined, digits: number) => {
      const value = column?.[index];
      return value === null || value === undefined ? "–" : significant(value, digits);
    };
    const at = `${this.options.x}: ${number(this.data[0], Math.max(5, digits))}`;
    return [at, ...this.options.series.map((one, i) => `${one.name} ${number(this.data[i + 1], digits)}${one.unit ? ` ${one.unit}` : ""}`)].join("   ");
  }

  private pressed(event: KeyboardEvent): void {
    const length = this.data[0]?.length ?? 0;
    if (length === 0) return;
    const now = this.cursor ?? (event.key === "ArrowLeft" ? length : -1);
    const step = event.shiftKey ? Math.max(1, Math.round(length / 50)) : 1;
    const to = { ArrowRight: now + step, ArrowLeft: now - step, Home: 0, End: length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.show(Math.min(length - 1, Math.max(0, to)));
  }

  /** A summary for those who do not see the curves. */
  private describe(): void {
    const parts = this.options.series.map((one, i) => {
      let [low, high] = [Infinity, -Infinity];
      for (const value of Array.from(this.data[i + 1] ?? [])) {
        if (value === null || !Number.isFinite(value)) continue;
        [low, high] = [Math.min(low, value), Math.max(high, value)];
      }
      return low > high ? `${one.name}: none` : `${one.name}: ${significant(low, 4)} to ${significant(high, 4)}`;
    });
    this.area.setAttribute("aria-description", `${this.options.y} over ${this.options.x}. ${parts.join("; ")}. Arrow keys move the cursor.`);
  }

  private header(): string[] {
    return [this.options.x, ...this.options.series.map((one) => one.name)];
  }

  private fill(): void {
    if (!this.details.open) return;
    const length = this.data[0]?.length ?? 0;
    const every = Math.max(1, Math.ceil(length / TABLE_ROWS));
    const head = el("tr", {}, ...this.header().map((name) => el("th", { scope: "col" }, name)));
    const body = el("tbody");
    for (let row = 0; row < length; row += every) {
      const cells = this.data.map((column) => column[row]);
      body.append(el("tr", {}, ...cells.map((value) => el("td", { class: "number" }, value === null || value === undefined ? "–" : significant(value, 6)))));
    }
    const caption = every > 1 ? `${this.options.title}: one in ${every} of ${length} rows` : this.options.title;
    this.rows.replaceChildren(el("table", {}, el("caption", {}, caption), el("thead", {}, head), body));
  }

  private csv(): void {
    const quoted = this.header().map((name) => `"${name.replaceAll('"', '""')}"`);
    const lines = Array.from({ length: this.data[0]?.length ?? 0 }, (_, row) => this.data.map((column) => column[row] ?? "").join(","));
    save(`${this.options.title.toLowerCase().replace(/[^a-z0-9]+/g, "-")}.csv`, [quoted.join(","), ...lines, ""].join("\n"), "text/csv");
  }
}

/** Slanted lines to fill with. */
function hatching(stroke: string): CanvasPattern | string {
  const [tile, side] = [document.createElement("canvas"), 5 * devicePixelRatio];
  tile.width = tile.height = side;
  const context = tile.getContext("2d");
  if (!context) return stroke;
  context.strokeStyle = stroke;
  context.lineWidth = 1.3 * devicePixelRatio;
  context.beginPath();
  for (const shift of [-side, 0, side]) {
    context.moveTo(shift, side);
    context.lineTo(shift + side, 0);
  }
  context.stroke();
  return context.createPattern(tile, "repeat") ?? stroke;
}
