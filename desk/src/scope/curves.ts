// Traces of a run over time: contour errors, corrections with their limits, flags; one cursor.

import { choice, el, tick } from "../core/dom";
import { Plot, type Series } from "../core/plot";
import type { ColourName } from "../core/theme";
import { KINDS, type Description } from "./documents";
import type { Rows } from "./rows";
import { rapids, RAPID, Strip, type Lane } from "./strip";

const SYNC = "scope";
/** Status bits of the step that report a deviation from normal operation (`trueaxis::telemetry::Status`). */
const STATUS: readonly (readonly [bit: number, name: string])[] = [
  [2, "frozen"],
  [4, "stop"],
  [32, "feedback out"],
  [64, "friction out"],
  [128, "lag out"],
];

/** Corrections that can be shown: columns of the rows up to the axis. */
const SHOWN = [
  ["compensated.correction", "geometry"],
  ["full.correction", "geometry, everything on"],
  ["full.sent", "dynamic, sent"],
  ["full.feed_forward", "feed-forward wanted"],
  ["full.feedback", "feedback wanted"],
  ["full.crosstalk", "cross-talk wanted"],
] as const;
type Shown = (typeof SHOWN)[number][0];

export type Mark = { x: number; text: string };

export class Curves {
  readonly root: HTMLElement;
  private readonly above = el("div");
  private readonly below = el("div");
  private readonly which;
  private readonly limits;
  private contour: Plot | undefined;
  private corrections: Plot | undefined;
  private strip: Strip | undefined;
  private description: Description | undefined;
  private rows: Rows | undefined;
  private marks: Mark[] = [];

  constructor(private readonly moved: (row: number | null) => void) {
    this.which = choice<Shown>("Shown", SHOWN, "compensated.correction", () => this.again());
    this.limits = tick("limits in sight", false, () => this.again());
    this.root = el("div", { class: "traces" }, this.above, el("div", { class: "row choose" }, this.which.root, this.limits.root), this.below);
  }

  open(description: Description): void {
    this.description = description;
    const dynamic = description.kinds.includes("full");
    if (!dynamic) this.which.value = "compensated.correction";
    this.which.root.hidden = !dynamic;
    this.rows = undefined;
    this.marks = [];
    this.build();
  }

  set(rows: Rows, marks: Mark[]): void {
    this.rows = rows;
    this.marks = marks;
    this.fill();
  }

  /** Moves the cursor of all plots. */
  show(row: number | null): void {
    this.contour?.show(row);
  }

  private again(): void {
    this.build();
    this.fill();
  }

  private get machine(): "compensated" | "full" {
    return this.which.value.startsWith("full") ? "full" : "compensated";
  }

  private build(): void {
    const { description } = this;
    if (!description) return;
    this.above.replaceChildren();
    this.below.replaceChildren();
    const series = description.kinds.map((kind): Series => ({ name: KINDS[kind].text, ...KINDS[kind] }));
    const common = { x: "time / s", sync: SYNC };
    this.contour = new Plot(this.above, { ...common, title: "Contour error of the true tool tip", y: "error / µm", series, height: 186, digits: 3, onCursor: this.moved, empty: "Run draws the contour error of each machine here.", shaded: RAPID });
    const y = description.axes.some(({ rotary }) => rotary) ? "correction / µm, µrad" : "correction / µm";
    this.corrections = new Plot(this.below, { ...common, title: "Correction of each axis", y, series: this.corrected(), height: 160, empty: "Run draws what each axis adds to its command here." });
    const words = this.all().map(({ axes, at }) => `${axes} ±${at}`);
    this.limits.root.lastChild!.textContent = ` limits in sight (${words.join("; ")} µm)`;
    this.strip = new Strip(this.below, `Flags of the step, ${KINDS[this.machine].text}`, SYNC);
  }

  private corrected(): Series[] {
    const axes = (this.description?.axes ?? []).map(({ axis, unit }): Series => ({ name: axis, colour: axis.toLowerCase() as ColourName, unit }));
    const limits = this.bounds().flatMap(({ axes, at }): Series[] => {
      const style = { colour: "warning" as const, dash: [7, 4], width: 1 };
      return [{ name: `limit of ${axes}: +${at}`, ...style }, { name: `−${at}`, ...style }];
    });
    return [...axes, ...limits];
  }

  /** Magnitude limits, one entry for all axes with the same limit. */
  private all(): { axes: string; at: number }[] {
    const by = new Map<number, string[]>();
    const geometry = this.which.value.endsWith("correction");
    for (const { axis, limits, dynamic_limits } of this.description?.axes ?? []) {
      const at = (geometry ? limits : dynamic_limits)?.magnitude;
      if (at !== undefined) by.set(at, [...(by.get(at) ?? []), axis]);
    }
    return [...by].map(([at, axes]) => ({ axes: axes.join(", "), at: Number(at.toPrecision(6)) }));
  }

  /** The magnitude limits to draw. */
  private bounds(): { axes: string; at: number }[] {
    return this.limits.input.checked ? this.all() : [];
  }

  private fill(): void {
    const { rows, description } = this;
    // uPlot needs at least one value for its axes.
    if (!rows?.count || !description || !this.contour || !this.corrections) return;
    const time = rows.column("time_s");
    this.contour.set([time, ...description.kinds.map((kind) => rows.curve(`${kind}.error_um`))]);
    const own = description.axes.map(({ axis }) => rows.curve(`${this.which.value}.${axis}`));
    const level = (at: number) => new Float64Array(rows.count).fill(at);
    this.corrections.set([time, ...own, ...this.bounds().flatMap(({ at }) => [level(at), level(-at)])]);
    const stretches = rapids(rows, time);
    this.contour.shade(stretches);
    this.corrections.shade(stretches);
    this.contour.mark(this.marks);
    this.corrections.mark(this.marks.map(({ x }) => ({ x, text: "" })));
    this.strip?.set(time, this.lanes(rows, description), this.marks.map(({ x }) => x));
  }

  private lanes(rows: Rows, { axes }: Description): Lane[] {
    const column = (name: string) => rows.column(`${this.machine}.${name}`);
    const bits = (name: string, bit: number) => column(name).map((value) => (value & bit ? 1 : 0));
    // Slots of the step: X, Y, Z, then the rotary axes.
    const slot = (axis: string) => ("XYZ".includes(axis) ? "XYZ".indexOf(axis) : 3 + axes.filter(({ rotary }) => rotary).findIndex((own) => own.axis === axis));
    const limited = axes.map(({ axis }): Lane => ({ name: `limited ${axis}`, colour: axis.toLowerCase() as ColourName, values: bits("limited", 1 << slot(axis)) }));
    const status = STATUS.map(([bit, name]): Lane => ({ name, colour: "before", values: bits("status", bit) }));
    return [...limited, { name: "fault", colour: "warning", values: column("fault") }, ...status];
  }
}
