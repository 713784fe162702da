// Results of a log: terms, curves, residuals, drift.

import { el, section } from "../core/dom";
import { Plot } from "../core/plot";
import { clearest } from "../core/sentence";
import { Sentence, showPlots, showTables } from "../core/shown";
import type { Found } from "./documents";

export class Results {
  readonly root: HTMLElement;
  private readonly sentence = new Sentence();
  private readonly figures = el("div", { class: "figures" });
  private readonly plots = el("div");
  private readonly residuals = el("div");

  constructor() {
    const plots = section("Residuals and curves", this.residuals, this.plots);
    this.root = el("div", {}, this.sentence.root, el("div", { class: "columns" }, plots, section("Errors found", this.figures)));
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show(found: Found): void {
    this.root.hidden = false;
    this.sentence.set(clearest(found.shown));
    showTables(this.figures, found.shown);
    this.drawResiduals(found);
    showPlots(this.plots, found.shown.plots);
  }

  private drawResiduals({ residuals: { residual_um, sigma_um, visits } }: Found): void {
    this.residuals.replaceChildren();
    const plot = new Plot(this.residuals, {
      title: "Residual of every touch",
      x: "touch",
      y: "residual / µm",
      height: 240,
      series: [
        { name: "left, positive outside the surface", colour: "after", dots: true, unit: "µm" },
        { name: "+ two standard deviations", colour: "servo", dash: [6, 4], unit: "µm" },
        { name: "− two standard deviations", colour: "servo", dash: [6, 4], unit: "µm" },
      ],
    });
    const across = (value: number) => residual_um.map(() => value);
    plot.set([residual_um.map((_, i) => i + 1), residual_um, across(2 * sigma_um), across(-2 * sigma_um)]);
    plot.mark(visits.map(([x, text]) => ({ x, text })));
  }
}
