// Results of a warm-up: drift of held-out cycles, lags and curves.

import { el, section } from "../core/dom";
import { Plot } from "../core/plot";
import { showTables } from "../core/shown";
import type { Drift, Fitted } from "./documents";

export class Results {
  readonly root: HTMLElement;
  private readonly plots = el("div");
  private readonly figures = el("div", { class: "figures" });

  constructor() {
    this.root = el("div", { class: "columns" }, section("Held-out cycles", this.plots), section("Model", this.figures));
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show({ shown, drifts }: Fitted): void {
    this.root.hidden = false;
    this.plots.replaceChildren();
    drifts.forEach((own) => this.draw(own));
    showTables(this.figures, shown);
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
}
