// One plane of the field as a colour map, before and after, and the largest error of every plane.

import { choice, el, slider, type Field } from "../core/dom";
import { significant } from "../core/number";
import { Plot } from "../core/plot";
import { onTheme, scale, colour } from "../core/theme";
import { millimetres, type Figures, type Half, type Rows } from "./field-document";

const LETTERS = ["X", "Y", "Z"] as const;
type Letter = (typeof LETTERS)[number];
const HALVES = ["before", "after"] as const;

export class Slice {
  private across = 2;
  private index = 0;
  /** Point of the readout, along the horizontal and the vertical axis of the maps. */
  private cursor: [number, number] = [0, 0];
  private rows: Rows | undefined;
  private figures: Figures | undefined;
  private readonly axis: ReturnType<typeof choice<Letter>>;
  private readonly place: Field;
  private readonly maps: Record<Half, HTMLCanvasElement>;
  private readonly readout = el("output", { class: "readout" });
  private readonly plot: Plot;

  /** `full`: size at the end of the scale, µm. */
  constructor(
    host: HTMLElement,
    private readonly full: (half: Half) => number,
  ) {
    this.axis = choice("Slice across", LETTERS.map((letter) => [letter, letter] as const), "Z", (letter) => this.turn(LETTERS.indexOf(letter)));
    this.place = slider({ label: "Plane", value: 1, min: 1, max: 11, step: 1 }, (plane) => this.move(plane - 1));
    const map = (half: Half) =>
      el("canvas", { class: "map", tabindex: 0, role: "img", "aria-label": `Slice ${half}`, onkeydown: (event: KeyboardEvent) => this.key(event), onpointermove: (event: PointerEvent) => this.point(event), "data-half": half });
    this.maps = { before: map("before"), after: map("after") };
    const figure = (half: Half) => el("figure", {}, el("figcaption", {}, `Slice ${half}`), this.maps[half]);
    const left = el("div", {}, el("div", { class: "row" }, this.axis.root, this.place.root), el("div", { class: "maps" }, figure("before"), figure("after")), this.readout);
    const right = el("div");
    host.append(el("div", { class: "columns" }, left, right));
    this.plot = new Plot(right, {
      title: "Largest error of every slice",
      x: "position of the slice / mm",
      y: "error / µm",
      series: [
        { name: "before", colour: "before", unit: "µm" },
        { name: "after, nine terms", colour: "full", dash: [6, 4], unit: "µm" },
        { name: "after, volumetric", colour: "after", dash: [2, 3], unit: "µm" },
      ],
      onCursor: (index) => index !== null && index !== this.index && this.move(index),
    });
    onTheme(this, (slice) => slice.paint());
  }

  state(): { across: number; index: number } {
    return { across: this.across, index: this.index };
  }

  open({ across, index }: { across: number; index: number }): void {
    [this.across, this.index] = [across, index];
    this.axis.value = LETTERS[across] ?? "Z";
  }

  show(rows: Rows, figures: Figures): void {
    const first = !this.figures || this.figures.points.join() !== figures.points.join();
    [this.rows, this.figures] = [rows, figures];
    if (figures.points[this.across]! < 2) this.across = figures.points.findIndex((count) => count > 1);
    this.axis.value = LETTERS[this.across] ?? "Z";
    if (first) {
      const { at_mm } = figures.before.worst;
      const places = figures.before.slices[this.across] ?? [];
      this.index = Math.max(0, places.findIndex((slice) => slice.at_mm === at_mm[this.across]));
    }
    this.paintAll();
  }

  /** Redraws after a change of scale. */
  paint(): void {
    if (!this.rows || !this.figures) return;
    for (const half of HALVES) this.map(half, this.rows, this.figures);
    this.read();
  }

  private turn(across: number): void {
    this.across = across;
    this.index = Math.min(this.index, (this.figures?.points[across] ?? 1) - 1);
    this.paintAll();
  }

  private move(index: number): void {
    this.index = index;
    this.place.value = index + 1;
    this.mark();
    this.paint();
  }

  private paintAll(): void {
    const { figures } = this;
    if (!figures) return;
    const count = figures.points[this.across] ?? 1;
    this.index = Math.min(this.index, count - 1);
    for (const input of this.place.root.querySelectorAll("input")) input.max = String(count);
    this.place.value = this.index + 1;
    const slices = [figures.before, figures.nine.after, figures.volumetric.after].map((one) => one?.slices[this.across]);
    const places = slices[0]?.map((slice) => slice.at_mm) ?? [];
    this.plot.set([places, ...slices.map((one) => one?.map((slice) => slice.largest_um) ?? places.map(() => null))]);
    this.mark();
    this.paint();
  }

  private mark(): void {
    const at = this.figures?.before.slices[this.across]?.[this.index]?.at_mm;
    if (at !== undefined) this.plot.mark([{ x: at, text: `${LETTERS[this.across]} ${millimetres(at)}` }]);
  }

  /** Machine axes along the horizontal and the vertical axis of a map. */
  private sides(): [number, number] {
    return [[1, 2], [0, 2], [0, 1]][this.across] as [number, number];
  }

  /** Row of the field at a point of the map. */
  private row(u: number, v: number, points: readonly number[]): number {
    const at = [0, 0, 0];
    const [horizontal, vertical] = this.sides();
    [at[this.across], at[horizontal], at[vertical]] = [this.index, u, v];
    return at[0]! + points[0]! * (at[1]! + points[1]! * at[2]!);
  }

  private map(half: Half, rows: Rows, { points, range_mm }: Figures): void {
    const canvas = this.maps[half];
    const [horizontal, vertical] = this.sides();
    const [columns, lines] = [points[horizontal]!, points[vertical]!];
    const extent = (axis: number) => range_mm[axis]![1] - range_mm[axis]![0] || 1;
    const width = 360;
    canvas.width = width;
    canvas.height = Math.round(Math.min(480, Math.max(90, (width * extent(vertical)) / extent(horizontal))));
    const context = canvas.getContext("2d");
    if (!context) return;
    const [wide, high] = [canvas.width / columns, canvas.height / lines];
    const full = this.full(half);
    let largest = 0;
    for (let v = 0; v < lines; v++)
      for (let u = 0; u < columns; u++) {
        const size = rows.sizesOf(half)[this.row(u, v, points)]!;
        largest = Math.max(largest, size);
        context.fillStyle = `rgb(${scale(size / full).map((part) => Math.round(255 * part)).join(" ")})`;
        context.fillRect(Math.floor(u * wide), Math.floor((lines - 1 - v) * high), Math.ceil(wide), Math.ceil(high));
      }
    const [u, v] = this.held(columns, lines);
    context.strokeStyle = colour("warning");
    context.lineWidth = 2;
    context.strokeRect(u * wide + 1, (lines - 1 - v) * high + 1, Math.max(3, wide - 2), Math.max(3, high - 2));
    const said = (axis: number) => `${LETTERS[axis]} ${millimetres(range_mm[axis]![0])} to ${millimetres(range_mm[axis]![1])} mm`;
    const text = `Slice ${half}: ${said(horizontal)} to the right, ${said(vertical)} upward; at most ${significant(largest, 4)} µm`;
    canvas.setAttribute("aria-label", `${text}. Arrow keys move the point that is read.`);
    canvas.previousElementSibling!.textContent = text;
  }

  /** The cursor, within the map. */
  private held(columns: number, lines: number): [number, number] {
    this.cursor = [Math.min(columns - 1, Math.max(0, this.cursor[0])), Math.min(lines - 1, Math.max(0, this.cursor[1]))];
    return this.cursor;
  }

  private read(): void {
    const { rows, figures } = this;
    if (!rows || !figures) return;
    const row = this.row(...this.cursor, figures.points);
    const numbers = rows.all.subarray(9 * row, 9 * row + 9);
    const three = (from: number) => Array.from(numbers.subarray(from, from + 3), (value) => significant(value, 4)).join(", ");
    const size = (half: Half) => significant(rows.sizesOf(half)[row]!, 4);
    const place = Array.from(numbers.subarray(0, 3), millimetres).join(", ");
    this.readout.textContent = `X, Y, Z ${place} mm   before ${three(3)} µm, size ${size("before")} µm   after ${three(6)} µm, size ${size("after")} µm`;
  }

  private key(event: KeyboardEvent): void {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    this.cursor = [this.cursor[0] + step[0]!, this.cursor[1] + step[1]!];
    this.paint();
  }

  private point(event: PointerEvent): void {
    const canvas = event.currentTarget as HTMLCanvasElement;
    const points = this.figures?.points;
    if (!points) return;
    const [horizontal, vertical] = this.sides();
    const u = Math.floor((event.offsetX / canvas.clientWidth) * points[horizontal]!);
    const v = points[vertical]! - 1 - Math.floor((event.offsetY / canvas.clientHeight) * points[vertical]!);
    if (u === this.cursor[0] && v === this.cursor[1]) return;
    this.cursor = [u, v];
    this.paint();
  }
}
