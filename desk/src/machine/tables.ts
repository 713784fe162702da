// Error tables: one error of an axis, plotted between the points as the step interpolates it, and edited.

import type { Desk } from "../core/desk";
import { button, choice, el, group, section, tick } from "../core/dom";
import { Plot } from "../core/plot";
import { onTheme } from "../core/theme";
import { columnsOf, pointsOf } from "./columns";
import { display } from "./display";
import { errorTitle, length, type Axis, type Column } from "./document";
import type { Editor } from "./editor";
import { Handles } from "./handles";
import { Points } from "./points";

/** Points of a curve: more than the plot has pixels. */
const CURVE_POINTS = 1200;

interface Chosen {
  axis: string;
  component: number;
}

export class Tables {
  readonly root: HTMLElement;
  chosen: Chosen = { axis: "X", component: 0 };
  private readonly axes = el("div", { class: "row tight", role: "group", "aria-label": "Axis" });
  private readonly place = el("div");
  private readonly none = el("p", { class: "said" }, "This axis has no table.");
  private readonly points: Points;
  private readonly errors: ReturnType<typeof choice<string>>;
  private readonly undo: HTMLButtonElement;
  private readonly redo: HTMLButtonElement;
  private readonly both = tick("Move both directions together", true, () => {});
  private readonly plots = new Map<string, { plot: Plot; handles: Handles }>();
  private drawn = 0;
  private listeners = new Set<() => void>();

  constructor(
    private readonly desk: Desk,
    private readonly editor: Editor,
  ) {
    this.errors = choice<string>("Error", [], "", (component) => this.choose({ ...this.chosen, component: Number(component) }));
    this.undo = button("Undo", () => void editor.undo(), { "aria-keyshortcuts": "Control+Z" });
    this.redo = button("Redo", () => void editor.redo(), { "aria-keyshortcuts": "Control+Shift+Z" });
    this.points = new Points(editor);
    this.root = section(
      "Error tables",
      el("div", { class: "row" }, group("Axis", this.axes), this.errors.root, this.undo, this.redo, this.both.root),
      this.none,
      this.place,
      el("p", { class: "said" }, "Drag a point, or select it with Tab and move it with the arrow keys: ↑ ↓ by 0.1, with Alt 0.01, with Shift 1; ← → to its neighbours. Drag beside the points to zoom, double-click to see all."),
      this.points.root,
    );
    editor.subscribe(() => this.render());
    display.subscribe(() => void this.curve());
    onTheme(this, (tables) => void tables.curve());
  }

  onChoice(listener: () => void): void {
    this.listeners.add(listener);
  }

  choose(chosen: Chosen): void {
    this.chosen = chosen;
    this.render();
    for (const listener of this.listeners) listener();
  }

  /** Selects another axis and keeps the selected error, except that a positioning error becomes the new axis' own. */
  private turn(axis: string): void {
    const own = (letter: string) => "XYZABC".indexOf(letter);
    const { component } = this.chosen;
    this.choose({ axis, component: component === own(this.chosen.axis) ? own(axis) : component });
  }

  get axis(): Axis | undefined {
    return this.editor.shown?.axes.find(({ axis }) => axis === this.chosen.axis);
  }

  render(): void {
    const axes = this.editor.shown?.axes ?? [];
    if (!this.axis) this.chosen.axis = axes.find(({ table }) => table)?.axis ?? axes[0]?.axis ?? "X";
    const axis = this.axis;
    const letters = axes.map((one) => one.axis).join("");
    if (this.axes.dataset.letters !== letters) {
      this.axes.dataset.letters = letters;
      this.axes.replaceChildren(...axes.map((one) => button(one.axis, () => this.turn(one.axis), { "data-axis": one.axis })));
    }
    for (const one of this.axes.children) one.setAttribute("aria-pressed", String((one as HTMLElement).dataset.axis === this.chosen.axis));
    const components = [...new Set(axis?.table?.columns.map(({ component }) => component).filter((one): one is number => one !== null))].sort();
    if (!components.includes(this.chosen.component)) this.chosen.component = components.includes("XYZABC".indexOf(this.chosen.axis)) ? "XYZABC".indexOf(this.chosen.axis) : (components[0] ?? 0);
    this.errors.select.replaceChildren(...components.map((one) => el("option", { value: one, selected: one === this.chosen.component }, errorTitle(this.chosen.axis, one))));
    this.steps();
    this.none.hidden = components.length > 0;
    this.place.hidden = components.length === 0;
    this.both.root.hidden = this.columns().length < 2;
    this.points.set(axis, this.columns());
    void this.curve();
  }

  private steps(): void {
    for (const [control, name, what] of [
      [this.undo, "Undo", this.desk.machine.undoable],
      [this.redo, "Redo", this.desk.machine.redoable],
    ] as const) {
      // Not `disabled`, which would lose the keyboard focus.
      control.setAttribute("aria-disabled", String(what === undefined));
      control.title = what ? `${name}: ${what}` : `Nothing to ${name.toLowerCase()}`;
    }
  }

  /** The columns of the selected error. */
  private columns(): Column[] {
    return columnsOf(this.axis, this.chosen.component);
  }

  private unit(): string {
    return this.chosen.component < 3 ? "µm" : "µrad";
  }

  private pair(): { plot: Plot; handles: Handles } {
    const position = length(this.axis?.unit ?? "mm");
    const key = `${position} ${this.unit()}`;
    let pair = this.plots.get(key);
    if (!pair) {
      const host = el("div");
      this.place.append(host);
      const plot = new Plot(host, {
        title: "The error as the step looks it up, through the points of the table",
        x: `position / ${position}`,
        y: `error / ${this.unit()}`,
        height: 280,
        digits: 5,
        series: [
          { name: "positive travel", colour: "after", width: 1.8 },
          { name: "negative travel", colour: "before", dash: [6, 4], width: 1.8 },
          { name: "with the growth", colour: "servo", dash: [2, 3] },
        ],
      });
      const handles = new Handles(plot, (column, row, value, gesture) => this.move(column, row, value, gesture));
      pair = { plot, handles };
      this.plots.set(key, pair);
    }
    for (const one of this.plots.values()) one.plot.root.hidden = one !== pair;
    return pair;
  }

  private move(column: string, row: number, value: number, gesture: number): Promise<void> {
    const axis = this.chosen.axis;
    const also = this.both.input.checked ? this.otherDirection(column, row, value) : [];
    return this.editor.apply({ change: "point", axis, column, row, value, also }, `${column}, row ${row + 1}: ${value} ${this.unit()}`, `${axis} ${column} ${row} ${gesture}`);
  }

  /** The column of the other direction, with its value moved by the same amount. */
  private otherDirection(column: string, row: number, value: number): [string, number][] {
    const table = this.axis?.table;
    const at = (name: string) => table?.rows[row]?.[table.columns.findIndex((one) => one.name === name)] ?? 0;
    const by = value - at(column);
    return this.columns()
      .filter(({ name }) => name !== column)
      .map(({ name }) => [name, Number((at(name) + by).toFixed(3))]);
  }

  /** Requests the curve from the module and draws it, unless a later request has replaced this one. */
  private async curve(): Promise<void> {
    const { axis } = this;
    if (!axis?.table || this.columns().length === 0) return;
    this.drawn += 1;
    const drawing = this.drawn;
    const { component } = this.chosen;
    const reference = this.editor.shown?.reference_temperature_c ?? 20;
    try {
      const temperature = display.temperature_c ?? reference;
      const all = await this.desk.bench.call("machine_curve", this.desk.machine.json, axis.axis, component, temperature, CURVE_POINTS);
      if (drawing !== this.drawn) return;
      const count = all.length / 4;
      const part = (index: number) => all.subarray(index * count, (index + 1) * count);
      const [positions, forward, reverse, growth] = [part(0), part(1), part(2), part(3)];
      const none = new Array<null>(count).fill(null);
      const two = reverse.some((value, i) => value !== forward[i]);
      const warm = growth.some((value) => value !== 0);
      const { plot, handles } = this.pair();
      plot.set([positions, forward, two ? reverse : none, warm ? forward.map((value, i) => value + (growth[i] ?? 0)) : none]);
      // The legend lists only the drawn curves.
      const legend = [...plot.root.querySelectorAll<HTMLElement>(".u-legend .u-series")].slice(-3);
      [true, two, warm].forEach((drawn, i) => legend[i] && (legend[i].style.display = drawn ? "" : "none"));
      const first = legend[0]?.querySelector(".u-label");
      if (first) first.textContent = two ? "positive travel" : "both directions of travel";
      handles.set(pointsOf(axis, component));
    } catch (error) {
      this.desk.fail(error);
    }
  }
}
