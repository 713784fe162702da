// Display of a test: tables, plots, a map.

import { el, section, table, type Cell } from "../core/dom";
import { fixed, significant } from "../core/number";
import { Plot, withBand, type Series } from "../core/plot";
import { showTables } from "../core/shown";
import type { Curve, Map, Plot as Plotted, Shown } from "../core/shown-types";
import { onTheme, scale, type ColourName } from "../core/theme";

const COLOURS: readonly ColourName[] = ["x", "y", "z", "a", "b"];
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 4]];

export class Results {
  readonly root: HTMLElement;
  private readonly plots = el("div");
  private readonly figures = el("div", { class: "figures" });
  private map: Map | null = null;
  private readonly mapped = el("div", { class: "mapped" });

  constructor() {
    this.root = el("div", { class: "columns" }, section("Plots", this.plots, this.mapped), section("Figures", this.figures));
    onTheme(this, (results) => results.paint());
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show(shown: Shown): void {
    this.root.hidden = false;
    showTables(this.figures, shown);
    this.plots.replaceChildren();
    for (const plot of shown.plots) this.draw(plot);
    this.map = shown.map;
    this.paint();
  }

  private draw({ title, x, y, look, caption, at, curves }: Plotted): void {
    const named = ([name, unit]: [string, string]) => (unit === "" ? name : `${name} / ${unit}`);
    const parts = curves.map((curve) => this.curve(curve, look, y[1]));
    const plot = new Plot(this.plots, { title, x: named(x), y: named(y), height: 240, series: parts.flatMap(({ series }) => series) });
    plot.set([at, ...parts.flatMap(({ columns }) => columns)]);
    // The report's bars are drawn as lines here.
    if (caption !== "") plot.root.querySelector("figcaption")?.after(el("small", {}, caption.replace("Bars:", "Thin lines:")));
  }

  private curve({ name, colour, dashed, values, expanded }: Curve, look: Plotted["look"], unit: string): { series: Series[]; columns: (number | null)[][] } {
    const own: Series = { name, unit, colour: COLOURS[colour % COLOURS.length]!, joined: true, points: look === "points", dots: look === "dotted", dash: dashed ? [2, 4] : (DASHES[colour % DASHES.length] ?? []) };
    const known = values.filter((value) => value !== null);
    return expanded.length > 0 && known.length === expanded.length ? withBand(own, known, expanded) : { series: [own], columns: [values] };
  }

  /** Colours behind the numbers. */
  private paint(): void {
    this.mapped.replaceChildren();
    if (!this.map) return;
    const { title, unit, caption, ends_mm: [x, y], rows } = this.map;
    const known = rows.flat().filter((value) => value !== null);
    const [low, high] = [Math.min(...known), Math.max(...known)];
    const middle = ([from, to]: [number, number], i: number, count: number) => fixed(from + ((i + 0.5) / count) * (to - from), 0);
    const cells = rows.map((row, j): Cell[] => [middle(y, j, rows.length), ...row.map((value): Cell => (value === null ? "" : { text: significant(value, 2), value }))]);
    const of = table(`${title}, ${unit}`, ["Y over X, mm", ...rows.map((_, i) => middle(x, i, rows.length))], cells.reverse());
    for (const cell of of.querySelectorAll<HTMLTableCellElement>("td[data-value]")) {
      const colour = scale(high > low ? (Number(cell.dataset.value) - low) / (high - low) : 0);
      cell.style.background = `rgb(${colour.map((part) => Math.round(255 * part)).join(" ")})`;
      cell.style.color = colour[1] > 0.5 ? "#000" : "#fff";
    }
    this.mapped.append(of, el("small", {}, caption));
  }
}
