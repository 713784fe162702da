// The field in three dimensions: a cone at every point, before and after side by side, rotated together.

import { button, el } from "../core/dom";
import { fixed, significant } from "../core/number";
import { colourBar, Scene } from "../core/scene";
import type { Vector } from "../core/space";
import type { Figures, Half, Rows, Worst } from "./field-document";

/** Longest cone in distances between points. */
const LONGEST = 1.6;

/** The largest of 1, 2, 5, 10, … that does not exceed a number. */
export function oneTwoFive(most: number): number {
  if (!(most > 0) || !Number.isFinite(most)) return 1;
  const decade = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].map((k) => k * decade).find((k) => k <= most * (1 + 1e-9)) ?? decade;
}

interface Panel {
  half: Half;
  root: HTMLElement;
  title: HTMLElement;
  legend: HTMLElement;
  scene: Scene;
  bar: (largest: string) => void;
}

export type Layout = "both" | Half;

export class Picture {
  readonly root = el("div", { class: "field-pictures" });
  private readonly panels: Panel[];
  private rows: Rows | undefined;
  private figures: Figures | undefined;
  private readonly own: HTMLButtonElement;
  private readonly layouts: Map<Layout, HTMLButtonElement>;
  layout: Layout = "both";
  /** Whether colours and cones after the correction have their own scale. */
  ownScale = false;

  constructor(
    host: HTMLElement,
    private readonly changed: () => void,
  ) {
    this.panels = (["before", "after"] as const).map((half) => this.panel(half));
    this.panels[1]!.scene.follow(this.panels[0]!.scene);
    const show = (layout: Layout, text: string) => button(text, () => this.set(layout, this.ownScale), { "aria-pressed": String(layout === this.layout) });
    this.layouts = new Map([
      ["both", show("both", "Both")],
      ["before", show("before", "Before")],
      ["after", show("after", "After")],
    ]);
    this.own = button("Own scale after", () => this.set(this.layout, !this.ownScale), { "aria-pressed": "false" });
    const choices = el("div", { role: "group", "aria-label": "Pictures shown", class: "row" }, ...this.layouts.values(), this.own);
    host.append(choices, this.root);
  }

  /** Sets the pictures shown and their scale. */
  set(layout: Layout, ownScale: boolean): void {
    [this.layout, this.ownScale] = [layout, ownScale];
    for (const [one, pressed] of this.layouts) pressed.setAttribute("aria-pressed", String(one === layout));
    this.own.setAttribute("aria-pressed", String(ownScale));
    for (const panel of this.panels) panel.root.hidden = layout !== "both" && layout !== panel.half;
    this.root.style.gridTemplateColumns = layout === "both" ? "" : "minmax(0, 1fr)";
    this.paint();
    this.changed();
  }

  show(rows: Rows, figures: Figures): void {
    [this.rows, this.figures] = [rows, figures];
    this.paint();
  }

  /** Size at the end of the colour scale, µm. */
  full(half: Half): number {
    return (this.ownScale ? this.rows?.largest(half) : this.rows?.largest("before")) || 1e-9;
  }

  private panel(half: Half): Panel {
    const title = el("figcaption", {}, half === "before" ? "Before" : "After");
    const legend = el("div", { class: "row" });
    const root = el("figure", {}, title);
    this.root.append(root);
    const scene = new Scene(root, { label: `Error of the tip ${half} the correction over the working volume`, height: 440 });
    const bar = colourBar(legend, "error");
    root.append(legend);
    return { half, root, title, legend, scene, bar };
  }

  private paint(): void {
    const { rows, figures } = this;
    if (!rows || !figures) return;
    for (const panel of this.panels) if (!panel.root.hidden) this.paintPanel(panel, rows, figures);
  }

  private paintPanel({ half, title, scene, bar }: Panel, rows: Rows, figures: Figures): void {
    const full = this.full(half);
    const [low, high] = [0, 1].map((end) => figures.range_mm.map((range) => range[end]) as Vector) as [Vector, Vector];
    const spacing = Math.min(...figures.points.flatMap((count, axis) => (count > 1 ? [(high[axis]! - low[axis]!) / (count - 1)] : [])));
    const magnification = oneTwoFive((LONGEST * spacing) / (full * 1e-3));
    scene.clear();
    const room = Math.max(...high.map((end, axis) => end - low[axis]!)) * 0.05;
    scene.fit(low.map((end) => end - room) as Vector, high.map((end) => end + room) as Vector);
    scene.box(low, high, ["X / mm", "Y / mm", "Z / mm"]);
    const values = rows.sizesOf(half).map((size) => size / full);
    scene.arrows(rows.columns(0), rows.columns(half === "before" ? 3 : 6), values, magnification * 1e-3, spacing * 0.14);
    const worst = half === "before" ? figures.before.worst : figures[figures.model].after?.worst;
    if (worst) this.mark(scene, worst, magnification);
    scene.draw();
    const what = half === "before" ? "Before" : `After, ${figures.model === "nine" ? "nine terms" : "volumetric"}`;
    title.textContent = `${what}: at most ${significant(rows.largest(half), 4)} µm, cones magnified ${magnification.toLocaleString("en")} times`;
    bar(`${significant(full, 3)} µm`);
  }

  private mark(scene: Scene, worst: Worst, magnification: number): void {
    scene.points(new Float32Array(worst.at_mm), "warning", 9);
    const tip = worst.at_mm.map((at, axis) => at + worst.error_um[axis]! * 1e-3 * magnification) as Vector;
    scene.lines(new Float32Array([...worst.at_mm, ...tip]), "warning");
    scene.label(tip, `worst ${fixed(worst.size_um, 2)} µm`);
  }
}
