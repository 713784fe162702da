// Figures, causes and curves of a circular test.

import { bars, el, section, table, warnings as warned, type Cell } from "../core/dom";
import { fixed, significant } from "../core/number";
import { Polar, keys, largest, type PolarSeries } from "../core/polar";
import type { Evaluated, Trace } from "./documents";

const um = (value: number | null): Cell => (value === null ? "–" : { text: significant(value, 4), value });

function way({ counterclockwise }: Trace): Pick<PolarSeries, "name" | "colour" | "dash"> {
  return counterclockwise ? { name: "counterclockwise", colour: "after" } : { name: "clockwise", colour: "before", dash: "7 3" };
}

export class Results {
  readonly root: HTMLElement;
  private readonly curves = el("div");
  private readonly figures = el("div", { class: "figures" });

  constructor() {
    this.root = el("div", { class: "columns" }, section("Deviation of the radius", this.curves), section("Figures and causes", this.figures));
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show({ document, values, traces }: Evaluated): void {
    this.root.hidden = false;
    this.draw(document.plane, traces);
    const { g_b_um, g_um, f_max_um, f_min_um, h_um, shares, warnings, centre_um, radius_deviation_um, sigma_um, condition, degrees_of_freedom } = document;
    const shared = table(
      "Causes in the order of their shares",
      ["cause", "share / %", "RMS / µm"],
      shares.map(({ cause, share, rms_um }): Cell[] => [cause, { text: fixed(100 * share, 1), value: 100 * share }, { text: significant(rms_um, 3), value: rms_um }]),
    );
    bars(shared, shares.map(({ share }) => share));
    this.figures.replaceChildren(
      warned(warnings),
      table("ISO 230-4, µm", ["figure", "both directions", "counterclockwise", "clockwise"], [
        ["G, circular deviation", um(g_b_um), um(g_um.ccw), um(g_um.cw)],
        ["F max", "", um(f_max_um.ccw), um(f_max_um.cw)],
        ["F min", "", um(f_min_um.ccw), um(f_min_um.cw)],
        ["H, hysteresis", um(h_um), "", ""],
      ]),
      shared,
      table("Values with half of their interval of 95 %", ["cause", "value", "± with 95 %"], values),
      table("Fit", ["", "value"], [
        ["centre, first axis / µm", um(centre_um[0])],
        ["centre, second axis / µm", um(centre_um[1])],
        ["radius / µm", um(radius_deviation_um)],
        ["sigma of a reading / µm", um(sigma_um)],
        ["degrees of freedom", { text: String(degrees_of_freedom), value: degrees_of_freedom }],
        ["condition number", um(condition)],
      ]),
    );
  }

  /** The deviation and its residual, each with its own scale. */
  private draw(plane: string, traces: Trace[]): void {
    const axes = [plane[0] ?? "X", plane[1] ?? "Y"] as const;
    const cells = el("div", { class: "grid" });
    this.curves.replaceChildren(keys(traces.map(way)), cells);
    const plots = [["Seen from the circle's centre", "deviation_um"], ["Residual of the causes", "left_um"]] as const;
    for (const [title, part] of plots) {
      const series = traces.map((trace): PolarSeries => ({ ...way(trace), angle_deg: trace.angle_deg, value_um: trace[part] }));
      new Polar(cells, title, axes, series, largest(series));
    }
  }
}
