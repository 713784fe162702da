// Results of a log: terms, curves, residuals, drift.

import { el, section, table, warnings, type Cell } from "../core/dom";
import { shown } from "../core/number";
import { Plot, withBand } from "../core/plot";
import type { ColourName } from "../core/theme";
import type { Found } from "./documents";

const whole = (value: number): Cell => ({ text: String(value), value });
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
    const { document: d } = found;
    this.figures.replaceChildren(
      warnings(d.warnings),
      table("Terms", ["term", "value", "standard error", "unit"], d.terms.map((term): Cell[] => [term.name, shown(term.value, 4), shown(term.standard_error, 2), term.unit])),
      table("Network", ["", "value"], [
        ["sigma of a touch / µm", shown(d.sigma_um, 3)],
        ["stated / µm", shown(d.repeatability_um, 3)],
        ["measured / µm RMS", shown(d.signal_um, 3)],
        ["degrees of freedom", whole(d.degrees_of_freedom)],
        ["unknowns, rank", whole(d.rank)],
        ["condition", shown(d.condition, 2)],
        ["radius of the tip / mm", shown(d.tip_radius_mm, 6)],
        ["its standard error / µm", shown(d.tip_radius_standard_error_um, 2)],
      ]),
      table("Artefacts, mm or °", ["artefact", "stated", "found", "± µm or µrad"], d.artefacts.map(({ name, stated, found, standard_error }): Cell[] => [name, whole(stated), shown(found, 8), shown(standard_error, 2)])),
    );
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

  private drawDrift({ document: { drift } }: Found): void {
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
