// A result as the module describes it: tables and plots.

import { bars, el, notes, table } from "./dom";
import { Plot, withBand, type Series } from "./plot";
import { keys, largest, Polar, type PolarSeries } from "./polar";
import type { Around, Cell, Curve, Look, Plot as Plotted, Polar as Circles, Shown, Table } from "./shown-types";
import type { ColourName } from "./theme";

/** By index, as in a report. */
const COLOURS: readonly ColourName[] = ["x", "y", "z", "a", "b", "before", "after", "servo", "measured"];
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 4]];
const colourOf = (index: number) => COLOURS[index % COLOURS.length]!;
const dashOf = (index: number) => DASHES[index % DASHES.length]!;

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
  const own: Series = { name, unit, colour: colourOf(colour), joined: true, points: look === "points", dots: look === "dotted", dash: dashed ? [2, 4] : dashOf(colour) };
  const [known, half] = [values, expanded].map((of) => of.filter((value) => value !== null)) as [number[], number[]];
  return half.length > 0 && half.length === values.length && known.length === values.length ? withBand(own, known, half) : { series: [own], columns: [values] };
}

/** Polar plots of a result side by side, those of a section on one scale. */
export function showPolars(host: HTMLElement, polars: Circles[]): void {
  const of = ({ name, colour, angle_deg, um }: Around): PolarSeries => ({ name, colour: colourOf(colour), dash: dashOf(colour).join(" "), angle_deg, value_um: um });
  const cells = el("div", { class: "grid polars" });
  host.replaceChildren(keys((polars[0]?.curves ?? []).map(of)), cells);
  for (const { section, title, axes, curves } of polars) {
    const most = largest(polars.flatMap((one) => (one.section === section ? one.curves.map(of) : [])));
    new Polar(cells, title, axes, curves.map(of), most);
  }
}
