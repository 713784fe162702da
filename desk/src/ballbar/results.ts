// Figures, causes and curves of a circular test.

import { el, section } from "../core/dom";
import { Polar, keys, largest, type PolarSeries } from "../core/polar";
import { showTables } from "../core/shown";
import type { Evaluated, Trace } from "./documents";

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

  show({ shown, plane, traces }: Evaluated): void {
    this.root.hidden = false;
    this.draw(plane, traces);
    showTables(this.figures, shown);
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
