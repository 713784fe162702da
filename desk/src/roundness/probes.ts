// Controls of an arrangement of three probes: points, band, angles in slots or degrees.

import { choice, el, group, numberField, slider, type Field } from "../core/dom";
import type { Probes } from "./documents";

type Unit = "slots" | "degrees";
const POINTS = [64, 128, 256, 512, 1024, 2048, 4096].map((n) => [String(n), String(n)] as const);

export class ProbeControls {
  readonly root: HTMLElement;
  private readonly angles = el("div", { class: "angles" });
  private readonly points;
  private readonly unit;
  private readonly first: Field;
  private readonly last: Field;

  constructor(
    legend: string,
    private probes: Probes,
    private readonly changed: () => void,
  ) {
    this.points = choice("Points of a revolution, N", POINTS, String(probes.n), (n) => this.resize(Number(n)));
    this.unit = choice<Unit>("Angles in", [["slots", "slots of 360°/N"], ["degrees", "degrees"]], "slots", (unit) => this.convert(unit));
    const [first, last] = this.band();
    this.first = numberField({ label: "First harmonic", value: first, min: 2, step: 1 }, () => this.reband());
    this.last = numberField({ label: "Last harmonic", value: last, min: 2, step: 1 }, () => this.reband());
    this.root = group(legend, this.points.root, this.first.root, this.last.root, this.unit.root, this.angles);
    this.show();
  }

  get value(): Probes {
    return this.probes;
  }

  set value(probes: Probes) {
    this.probes = probes;
    this.show();
  }

  /** Sets all controls to the value without reporting it. */
  private show(): void {
    const { probes } = this;
    const slots = probes.p !== undefined;
    this.points.value = String(probes.n);
    this.unit.value = slots ? "slots" : "degrees";
    [this.first.value, this.last.value] = this.band();
    for (const field of [this.first, this.last]) field.input.max = String(probes.n / 2 - 1);
    const range = slots ? { min: 1, max: probes.n - 1, step: 1, unit: "slots" } : { min: 0, max: 360, step: 0.01, unit: "°" };
    const [one, two] = slots ? (["p", "q"] as const) : (["phi2_deg", "phi3_deg"] as const);
    const angle = (key: "p" | "q" | "phi2_deg" | "phi3_deg", label: string) =>
      slider({ label, value: probes[key] ?? 0, ...range }, (value) => {
        this.probes = { ...this.probes, [key]: value };
        this.changed();
      }).root;
    this.angles.replaceChildren(angle(one, "φ2, probe 1 to 2"), angle(two, "φ3, probe 2 to 3"));
  }

  private band(): [number, number] {
    return this.probes.harmonics ?? [2, Math.min(100, this.probes.n / 2 - 1)];
  }

  private reband(): void {
    this.probes = { ...this.probes, harmonics: [this.first.value, this.last.value] };
    this.changed();
  }

  /** Sets another number of points; the angles stay as close as slots allow. */
  private resize(n: number): void {
    const { p, q, n: before } = this.probes;
    const [first, last] = this.band();
    const slot = (of: number) => Math.min(n - 1, Math.max(1, Math.round((of * n) / before)));
    const slots = p !== undefined && q !== undefined ? { p: slot(p), q: slot(q) } : {};
    this.probes = { ...this.probes, ...slots, n, harmonics: [first, Math.min(last, n / 2 - 1)] };
    this.show();
    this.changed();
  }

  private convert(unit: Unit): void {
    const { n, p = 1, q = 1, phi2_deg = 0, phi3_deg = 0, ...rest } = this.probes;
    const slot = (degrees: number) => Math.min(n - 1, Math.max(1, Math.round((degrees * n) / 360)));
    this.probes =
      unit === "slots"
        ? { ...rest, n, p: slot(phi2_deg), q: slot(phi3_deg) }
        : { ...rest, n, phi2_deg: (360 * p) / n, phi3_deg: (360 * q) / n };
    this.show();
    this.changed();
  }
}
