// A result as the module describes it: tables and plots.

import { bars, el, notes, table } from "./dom";
import { Plot, withBand, type Series } from "./plot";
import type { Cell, Curve, Look, Plot as Plotted, Shown, Table } from "./shown-types";
import type { ColourName } from "./theme";

/** By index, as in a report. */
const COLOURS: readonly ColourName[] = ["x", "y", "z", "a", "b", "before", "after", "servo"];
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 4]];

/** A table of a result. */
export function tabled({ caption, header, rows, bars: column }: Table): HTMLElement {
  const of = table(caption, header, rows);
  const share = (cell: Cell | undefined) => (typeof cell === "object" ? cell.value / 100 : 0);
  if (column !== null) bars(of, rows.map((row) => share(row[column])));
  return of;
}

/** Notes and tables of a result. */
export function showTables(host: HTMLElement, shown: Shown): void {
  host.replaceChildren(notes("Notes", shown.notes, "warning"), ...shown.tables.map(tabled));
}

/** Plots of a result, one below the other. */
export function showPlots(host: HTMLElement, plots: Plotted[]): void {
  host.replaceChildren();
  for (const { title, x, y, look, caption, at, curves } of plots) {
    const named = ([name, unit]: [string, string]) => (unit === "" ? name : `${name} / ${unit}`);
    const parts = curves.map((curve) => drawn(curve, look, y[1]));
    const plot = new Plot(host, { title, x: named(x), y: named(y), height: 240, series: parts.flatMap(({ series }) => series) });
    plot.set([at, ...parts.flatMap(({ columns }) => columns)]);
    // The report's bars are drawn as lines here.
    if (caption !== "") plot.root.querySelector("figcaption")?.after(el("small", {}, caption.replace("Bars:", "Thin lines:")));
  }
}

function drawn({ name, colour, dashed, values, expanded }: Curve, look: Look, unit: string): { series: Series[]; columns: (number | null)[][] } {
  const own: Series = { name, unit, colour: COLOURS[colour % COLOURS.length]!, joined: true, points: look === "points", dots: look === "dotted", dash: dashed ? [2, 4] : (DASHES[colour % DASHES.length] ?? []) };
  const [known, half] = [values, expanded].map((of) => of.filter((value) => value !== null)) as [number[], number[]];
  return half.length > 0 && half.length === values.length && known.length === values.length ? withBand(own, known, half) : { series: [own], columns: [values] };
}
