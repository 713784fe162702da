// Results of a log: terms, curves, residuals, drift.

import { el, section } from "../core/dom";
import { Plot, withBand } from "../core/plot";
import { showTables } from "../core/shown";
import type { ColourName } from "../core/theme";
import type { Found } from "./documents";

const XYZ = ["X", "Y", "Z"] as const;
const colour = (letter: string) => letter.toLowerCase() as ColourName;
const DASHES = [[], [7, 3], [2, 3]];

export class Results {
  readonly root: HTMLElement;
  private readonly figures = el("div", { class: "figures" });
  private readonly curves = el("div");
  private readonly residuals = el("div");
  private readonly drift = el("div");

  constructor() {
    const plots = section("Residuals and curves", this.residuals, this.curves, this.drift);
    this.root = el("div", { class: "columns" }, plots, section("Errors found", this.figures));
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show(found: Found): void {
    this.root.hidden = false;
    showTables(this.figures, found.shown);
    this.drawResiduals(found);
    this.drawCurves(found);
    this.drawDrift(found);
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

  private drawCurves({ curves }: Found): void {
    this.curves.replaceChildren();
    for (const { axis, position_mm, error_um, expanded_um } of curves) {
      const parts = XYZ.map((direction, i) => withBand({ name: `E${direction}${axis}`, colour: colour(direction), dash: DASHES[i]!, unit: "µm" }, error_um[i]!, expanded_um[i]!));
      const plot = new Plot(this.curves, {
        title: `Errors found of axis ${axis}, between lines of their expanded uncertainty, 95 %`,
        x: `${axis} / mm`,
        y: "error / µm",
        series: parts.flatMap(({ series }) => series),
      });
      plot.set([position_mm, ...parts.flatMap(({ columns }) => columns)]);
    }
  }

  private drawDrift({ drift }: Found): void {
    this.drift.replaceChildren();
    if (drift.length < 2) return;
    const plot = new Plot(this.drift, {
      title: "Drift of the reference from its first probing on",
      x: "time without pauses / min",
      y: "drift / µm",
      series: XYZ.map((letter, i) => ({ name: letter, colour: colour(letter), dash: DASHES[i]!, dots: true, unit: "µm" })),
    });
    plot.set([drift.map(({ time_s }) => time_s / 60), ...XYZ.map((_, i) => drift.map(({ um }) => um[i]!))]);
  }
}
