// Results of a warm-up: drift of held-out cycles, lags and curves.

import { el, section, table, type Cell } from "../core/dom";
import { shown, significant } from "../core/number";
import { Plot } from "../core/plot";
import type { Drift, Fit, Fitted } from "./documents";

/** Values with their standard errors. */
const pairs = (values: number[], errors: number[]) => values.map((value, i) => `${significant(value, 3)} ± ${significant(errors[i]!, 2)}`).join(", ");

export class Results {
  readonly root: HTMLElement;
  private readonly left = el("p", { class: "result" });
  private readonly plots = el("div");
  private readonly figures = el("div", { class: "figures" });

  constructor() {
    this.root = el("div", { class: "columns" }, section("Held-out cycles", this.left, this.plots), section("Model", this.figures));
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show({ document: d, drifts }: Fitted): void {
    this.root.hidden = false;
    const [drift, left] = d.held_out_um;
    this.left.textContent = `Of a largest drift of ${significant(drift, 3)} µm, ${significant(left, 3)} µm remain.`;
    this.plots.replaceChildren();
    drifts.forEach((own) => this.draw(own));
    this.figures.replaceChildren(...this.tables(d));
  }

  private draw({ axis, cycle, point_mm: [x, y, z, tool], hours, measured_um, said_um, left_um }: Drift): void {
    const plot = new Plot(this.plots, {
      title: `Drift of ${axis} in cycle ${cycle} at X ${x}, Y ${y}, Z ${z}, tool ${tool} mm`,
      x: "time since the cycle began / h",
      y: "drift / µm",
      series: [
        { name: "measured", colour: "before", unit: "µm" },
        { name: "by the task", colour: "after", dash: [7, 3], unit: "µm" },
        { name: "left", colour: "servo", dash: [2, 3], unit: "µm" },
      ],
    });
    plot.set([hours, measured_um, said_um, left_um]);
  }

  private tables(d: Fit): HTMLElement[] {
    const cycles = d.cycles.map((own): Cell[] => [`E${own.axis}${own.axis}, cycle ${own.cycle}`, shown(own.drift_um), shown(own.left_um), shown(own.left_rms_um), own.held_out ? "held out" : ""]);
    const lags = d.sensors.map(({ name, lag_s }): Cell[] => [name, shown(lag_s)]);
    if (d.spindle_lag_s !== null) lags.push(["spindle", shown(d.spindle_lag_s)]);
    const curves = d.axes.flatMap(({ axis, curves }) =>
      curves.map((of): Cell[] => [`E${axis}${axis}, ${of.of}`, of.knots.map((knot) => significant(knot, 3)).join(", "), pairs(of.offset_um, of.offset_error_um), pairs(of.slope, of.slope_error)]),
    );
    const tables = [
      table("Drift and remainder", ["", "largest drift / µm", "left / µm", "left, RMS / µm", ""], cycles),
      table("Lags", ["sensor", "lag / s"], lags),
      table("Curves", ["", "knots / °C or rpm", "offset or growth / µm", "slope / µm/m, tilt / µrad"], curves),
    ];
    if (d.left_out.length > 0) tables.push(table("Left out", ["sensor", "why"], d.left_out.map(({ name, reason }): Cell[] => [name, reason])));
    const why = (cycle: number): string => `run in cycle ${cycle} only, so that no other cycle predicts it`;
    const unconfirmed = d.unconfirmed.map(({ rpm, cycle }): Cell[] => [`${rpm} rpm`, why(cycle)]);
    if (unconfirmed.length > 0) tables.push(table("Unconfirmed", ["speed", "why"], unconfirmed));
    return tables;
  }
}
