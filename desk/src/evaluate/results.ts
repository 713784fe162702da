// Display of a test: tables, plots, a map.

import { el, section, table, type Cell } from "../core/dom";
import { fixed, significant } from "../core/number";
import { clearest } from "../core/sentence";
import { Sentence, showPlots, showTables } from "../core/shown";
import type { Map, Shown } from "../core/shown-types";
import { inkOn, onTheme, scale } from "../core/theme";

export class Results {
  readonly root: HTMLElement;
  private readonly sentence = new Sentence();
  private readonly plots = el("div");
  private readonly figures = el("div", { class: "figures" });
  private map: Map | null = null;
  private readonly mapped = el("div", { class: "mapped" });

  constructor() {
    this.root = el("div", {}, this.sentence.root, el("div", { class: "columns" }, section("Plots", this.plots, this.mapped), section("Figures", this.figures)));
    onTheme(this, (results) => results.paint());
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show(shown: Shown): void {
    this.root.hidden = false;
    this.sentence.set(clearest(shown));
    showTables(this.figures, shown);
    showPlots(this.plots, shown.plots);
    this.map = shown.map;
    this.paint();
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
      cell.style.color = inkOn(colour);
    }
    this.mapped.append(of, el("small", {}, caption));
  }
}
