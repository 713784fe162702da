// A result as the module describes it: tables and plots.

import { bars, el, notes, table, unique } from "./dom";
import { Plot, withBand, type Series } from "./plot";
import { keys, largest, Polar, type PolarSeries } from "./polar";
import type { Around, Cell, Curve, Look, Plot as Plotted, Polar as Circles, Shown, Table } from "./shown-types";
import type { ColourName } from "./theme";

/** By index, as in a report. */
const COLOURS: readonly ColourName[] = ["x", "y", "z", "a", "warning", "before", "after", "servo", "measured"];
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

/** Tables of a result; those without rows are left out, as on the command line. */
export const tabledAll = (tables: Table[]): HTMLElement[] => tables.filter(({ rows }) => rows.length > 0).map(tabled);

/** A result in a sentence, above its plots and tables. */
export class Sentence {
  readonly root = el("p", { class: "result", hidden: true });

  set(text: string): void {
    this.root.textContent = text.slice(0, 1).toUpperCase() + text.slice(1);
    this.root.hidden = text === "";
  }
}

/** Notes and tables of a result. */
export function showTables(host: HTMLElement, shown: Shown): void {
  host.replaceChildren(notes("Notes", shown.notes, "warning"), ...tabledAll(shown.tables));
}

/**
 * Plots of a result, one below the other; the cursors of those of a section move together. Returns a function that draws later
 * states of the same plots.
 */
export function showPlots(host: HTMLElement, plots: Plotted[]): (later: Plotted[]) => void {
  const key = unique("shown");
  const parts = ({ look, y, at, limit, curves }: Plotted): Part[] => {
    const across: Part[] = limit === null ? [] : [{ series: [{ name: "limit", colour: "warning", dash: [6, 4] }], columns: [at.map(() => limit)] }];
    return [...curves.map((curve) => drawn(curve, look, y[1])), ...across];
  };
  const named = ([name, unit]: [string, string]) => (unit === "" ? name : `${name} / ${unit}`);
  host.replaceChildren();
  const own = plots.map((of) => {
    const series = parts(of).flatMap((part) => part.series);
    const plot = new Plot(host, { title: of.title, x: named(of.x), y: named(of.y), height: 240, series, logarithmic: of.logarithmic, sync: `${key} ${of.section}` });
    // The report's bars are drawn as lines here.
    if (of.caption !== "") plot.root.querySelector("figcaption")?.after(el("small", {}, of.caption.replace("Bars:", "Thin lines:")));
    return plot;
  });
  const set = (later: Plotted[]) => later.forEach((of, i) => own[i]?.set([of.at, ...parts(of).flatMap(({ columns }) => columns)]));
  set(plots);
  return set;
}

/** A curve as drawn: its lines and their values. */
interface Part {
  series: Series[];
  columns: (number | null)[][];
}

function drawn({ name, colour, dashed, values, expanded }: Curve, look: Look, unit: string): Part {
  const own: Series = { name, unit, colour: colourOf(colour) };
  if (look === "columns") return { series: [{ ...own, bars: dashed ? "hatched" : "solid" }], columns: [values] };
  const line: Series = { ...own, joined: true, points: look === "points", dots: look === "dotted", dash: dashed ? [2, 4] : dashOf(colour) };
  const [known, half] = [values, expanded].map((of) => of.filter((value) => value !== null)) as [number[], number[]];
  return half.length > 0 && half.length === values.length && known.length === values.length ? withBand(line, known, half) : { series: [line], columns: [values] };
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
