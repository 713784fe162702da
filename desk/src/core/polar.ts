// Radial deviation over the angle, magnified about the circle, as on a ballbar plot.

import { button, el, table, unique, type Cell } from "./dom";
import { save } from "./files";
import { cell, fixed, significant } from "./number";
import type { ColourName } from "./theme";

export interface PolarSeries {
  name: string;
  colour: ColourName;
  dash?: string;
  angle_deg: number[];
  value_um: number[];
}

const SIZE = 340;
const RADIUS = 74;
/** Distance from the circle at which the largest deviation is drawn. */
const REACH = 62;
/** Half the length of the axes. */
const END = RADIUS + REACH + 8;
/** Angles further apart than this are not joined, degrees. */
const GAP = 5;

/** Angle between two directions, degrees. */
function between(one: number, other: number): number {
  const apart = Math.abs(one - other) % 360;
  return Math.min(apart, 360 - apart);
}

/** An element of a drawing. */
export function draw<K extends keyof SVGElementTagNameMap>(name: K, attributes: Record<string, string | number>, text = ""): SVGElementTagNameMap[K] {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.textContent = text;
  return element;
}

/** The largest of 1, 2 or 5 times a power of ten of which `most` contains at least two. */
function step(most: number): number {
  const power = 10 ** Math.floor(Math.log10(most / 2));
  return [1, 2, 5].map((digit) => digit * power).findLast((size) => size <= most / 2) ?? power;
}

/** Largest deviation of some curves, µm. */
export function largest(all: PolarSeries[]): number {
  let most = 1e-3;
  for (const { value_um } of all) for (const value of value_um) most = Math.max(most, Math.abs(value));
  return most;
}

/** A legend that explains the dashes. */
export function keys(entries: readonly { name: string; colour: ColourName; dash?: string }[]): HTMLElement {
  const parts = entries.map(({ name, colour, dash }) => {
    const line = draw("svg", { viewBox: "0 0 28 8", "aria-hidden": "true" });
    line.append(draw("line", { x1: 0, x2: 28, y1: 4, y2: 4, stroke: `var(--${colour})`, "stroke-width": 2, "stroke-dasharray": dash ?? "none" }));
    return el("span", {}, line, name);
  });
  return el("div", { class: "keys" }, ...parts);
}

export class Polar {
  private readonly cursor = draw("g", { class: "cursor", visibility: "hidden" });
  private readonly readout: HTMLElement;
  private readonly factor: number;
  private at: number | null = null;

  /** `most` is the largest deviation: one scale for circles side by side. */
  constructor(
    host: HTMLElement,
    private readonly title: string,
    axes: readonly [string, string],
    private readonly series: PolarSeries[],
    most: number,
  ) {
    const id = unique("polar");
    this.factor = REACH / most;
    const picture = draw("svg", { viewBox: `${-SIZE / 2} ${-SIZE / 2} ${SIZE} ${SIZE}`, "aria-hidden": "true" });
    const rings = [-4, -3, -2, -1, 0, 1, 2, 3, 4].map((k) => k * step(most)).filter((value) => Math.abs(value) <= most * 1.02);
    this.grid(picture, rings);
    for (const one of series)
      picture.append(draw("path", { d: this.path(one), fill: "none", stroke: `var(--${one.colour})`, "stroke-width": 1.5, "stroke-dasharray": one.dash ?? "none", "stroke-linejoin": "round" }));
    this.labels(picture, rings, step(most), axes);
    picture.append(this.cursor);
    const words = series.map(({ name, value_um }) => `${name}: ${significant(Math.min(...value_um), 3)} to ${significant(Math.max(...value_um), 3)} µm`).join("; ");
    const area = el("div", { class: "dial", tabindex: 0, role: "img", "aria-labelledby": id, "aria-description": words, onkeydown: (event: KeyboardEvent) => this.key(event) });
    area.append(picture);
    this.readout = el("output", { class: "readout", for: id });
    const details = el("details", { ontoggle: () => this.fill(details) }, el("summary", {}, "Table"));
    host.append(el("figure", {}, el("figcaption", { id }, title), area, this.readout, details));
  }

  private place(angle_deg: number, value_um: number): [number, number] {
    const [angle, radius] = [(angle_deg * Math.PI) / 180, RADIUS + this.factor * value_um];
    return [radius * Math.cos(angle), -radius * Math.sin(angle)];
  }

  private path({ angle_deg, value_um }: PolarSeries): string {
    const parts: string[] = [];
    angle_deg.forEach((angle, i) => {
      const [x, y] = this.place(angle, value_um[i]!);
      const joined = i > 0 && between(angle, angle_deg[i - 1]!) < GAP;
      parts.push(`${joined ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`);
    });
    const [first, last] = [angle_deg[0], angle_deg.at(-1)];
    if (first !== undefined && last !== undefined && between(first, last) < GAP) {
      const [x, y] = this.place(first, value_um[0]!);
      parts.push(`L${x.toFixed(2)} ${y.toFixed(2)}`);
    }
    return parts.join("");
  }

  private grid(picture: SVGElement, rings: number[]): void {
    for (const [x, y] of [[END, 0], [0, END]] as const) picture.append(draw("line", { x1: -x, x2: x, y1: -y, y2: y, class: "ring" }));
    for (const value of rings) picture.append(draw("circle", { r: RADIUS + this.factor * value, class: value === 0 ? "nominal" : "ring" }));
  }

  private labels(picture: SVGElement, rings: number[], ring: number, [first, second]: readonly [string, string]): void {
    for (const value of rings.filter((value) => value !== 0)) {
      const [x, y] = this.place(45, value);
      picture.append(draw("text", { x, y, class: "scale" }, `${value > 0 ? "+" : "−"}${significant(Math.abs(value), 1)}`));
    }
    picture.append(
      draw("text", { x: END + 3, y: 4 }, `+${first}`),
      draw("text", { x: 0, y: -END - 4, "text-anchor": "middle" }, `+${second}`),
      draw("text", { x: 0, y: 4, "text-anchor": "middle", class: "scale" }, `rings of ${significant(ring, 1)} µm`),
    );
  }

  /** The value of a series nearest to an angle. */
  private near({ angle_deg, value_um }: PolarSeries, angle: number): number | null {
    let best = 0;
    angle_deg.forEach((one, i) => {
      if (between(one, angle) < between(angle_deg[best]!, angle)) best = i;
    });
    return between(angle_deg[best] ?? NaN, angle) < 1 ? value_um[best]! : null;
  }

  private key(event: KeyboardEvent): void {
    const angles = this.series[0]?.angle_deg ?? [];
    if (angles.length === 0) return;
    const now = this.at ?? -1;
    const by = event.shiftKey ? 20 : 1;
    const to = { ArrowRight: now + by, ArrowLeft: now - by, Home: 0, End: angles.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.at = (to + angles.length) % angles.length;
    const angle = angles[this.at]!;
    this.cursor.setAttribute("visibility", "visible");
    const [[x1, y1], [x2, y2]] = [this.place(angle, -REACH / this.factor), this.place(angle, REACH / this.factor)];
    this.cursor.replaceChildren(draw("line", { x1, y1, x2, y2 }));
    const values = this.series.map((one) => `${one.name} ${significant(this.near(one, angle) ?? NaN, 3)} µm`);
    this.readout.textContent = [`${fixed(angle, 1)}°`, ...values].join("   ");
  }

  private rows(): Cell[][] {
    const angles = this.series[0]?.angle_deg ?? [];
    return angles.map((angle) => [cell(angle, 2), ...this.series.map((one) => cell(this.near(one, angle), 4))]);
  }

  private fill(details: HTMLDetailsElement): void {
    if (!details.open || details.childElementCount > 1) return;
    const header = ["angle / °", ...this.series.map(({ name }) => `${name} / µm`)];
    const rows = this.rows();
    const csv = () => {
      const value = (one: Cell) => (typeof one === "string" ? "" : String(one.value));
      const names = header.map((name) => name.replaceAll(",", ""));
      save(`${this.title}.csv`, [names, ...rows.map((row) => row.map(value))].map((row) => row.join(",")).join("\n") + "\n", "text/csv");
    };
    const shown = el("div", { class: "rows", tabindex: 0, role: "group", "aria-label": `${this.title}: numbers` }, table(this.title, header, rows));
    details.append(shown, button("Save CSV", csv));
  }
}
