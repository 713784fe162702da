// Interactive view of a gear's flank, the tool on it, and the positions of the five axes.

import "./helicoid.css";
import { message, type Desk, type View } from "../core/desk";
import { choice, debounce, el, section, slider, type Field } from "../core/dom";
import { tabled } from "../core/shown";
import { Curves, type Line } from "./curves";
import type { Limits, Outline, Tool } from "./documents";
import { Flank } from "./flank";
import { form } from "./form";
import { Travel } from "./limits";
import { displacements, place, travel } from "./live";
import { Picture } from "./picture";
import { Program } from "./program";
import { request, START, type Inputs, type Span } from "./request";

/** State for a link. */
interface State {
  inputs: Inputs;
  at: [number, number];
  line: Line;
  travel: unknown;
}

class Window {
  inputs: Inputs = structuredClone(START);
  at: [number, number] = [0.35, 0.1];
  line: Line = "theta";
  private outline: Outline | undefined;
  private limits: Limits = {};
  /** Counts the requests, so that a late response is discarded. */
  private asked = 0;
  private moves = 0;
  private readonly fields = el("div");
  private readonly refused = el("p", { role: "alert", class: "warning" });
  private readonly notes = el("p", { role: "status", class: "said" });
  private readonly sliders = el("div", { class: "place" });
  private readonly live = el("div");
  private readonly data = el("div");
  private readonly tables = el("div", { class: "tables" });
  private readonly results = el("div");
  private readonly picture: Picture;
  private readonly curves: Curves;
  private readonly flank: Flank;
  private readonly program: Program;
  readonly travel: Travel;
  private readonly along: { root: HTMLElement; value: Line };
  private both: [Field, Field] | undefined;
  private readonly soon: () => void;
  private readonly soonErrors: () => void;
  private readonly soonLines: () => void;

  constructor(
    root: HTMLElement,
    private readonly desk: Desk,
  ) {
    this.soon = debounce(40, () => void this.refresh());
    this.soonLines = debounce(60, () => void this.lines().catch((error: unknown) => desk.fail(error)));
    this.soonErrors = debounce(200, () => void this.errors().catch((error: unknown) => desk.fail(error)));
    this.picture = new Picture(desk);
    this.curves = new Curves(desk, (value) => this.cursor(value));
    this.flank = new Flank(desk);
    this.program = new Program(desk, () => this.inputs, () => this.outline?.fit);
    this.travel = new Travel(() => this.soon());
    this.along = choice("Curves over", [["theta", "θ, the helix"], ["u", "u, the involute"]] as const, this.line, (line) => {
      this.line = line;
      this.soonLines();
      this.soonErrors();
    });
    this.results.append(
      section("Tool on the flank", this.picture.root, this.sliders, this.live),
      section("Displacements", el("div", { class: "row" }, this.along.root), this.curves.root),
      section("Error along the flank", this.program.machine, this.flank.root),
      section("Travel", this.travel.root, this.tables),
    );
    root.append(
      el("div", { class: "bench" },
        el("div", {}, section("Inputs", this.fields, this.refused, this.notes), this.data),
        this.results),
      section("Program", this.program.root));
    desk.machine.subscribe(() => this.soon());
  }

  /** Rebuilds fields and sliders from the inputs. */
  async start(): Promise<void> {
    this.fields.replaceChildren(form(this.inputs, () => this.soon()));
    this.along.value = this.line;
    await this.refresh();
  }

  /** Updates everything after a change of the inputs, the limits or the machine. */
  private async refresh(): Promise<void> {
    const token = ++this.asked;
    const { inputs, desk } = this;
    try {
      const outline = JSON.parse(await desk.bench.call("helicoid_outline", request(inputs), this.travel.asked(), desk.machine.json)) as Outline;
      if (token !== this.asked) return;
      this.outline = outline;
      this.refused.textContent = "";
      this.results.classList.remove("stale");
    } catch (error) {
      if (token !== this.asked) return;
      this.refused.textContent = message(error);
      this.results.classList.add("stale");
      return;
    }
    const { outline } = this;
    this.notes.textContent = outline.notes.join(" ");
    this.limits = this.travel.of(outline.fit);
    this.place();
    this.data.replaceChildren(tabled(outline.flank));
    this.tables.replaceChildren(...outline.reach.map(travel));
    this.program.set();
    try {
      await this.picture.surface(inputs);
      await Promise.all([this.tool(), this.lines()]);
    } catch (error) {
      this.desk.fail(error);
    }
    this.soonErrors();
  }

  /** Sliders over the range of the grid. */
  private place(): void {
    const ends = ({ start, stop, count }: Span): [number, number] => (count === 1 ? [start, start] : [Math.min(start, stop), Math.max(start, stop)]);
    const ranges = [ends(this.inputs.u), ends(this.inputs.theta)] as const;
    for (const i of [0, 1] as const) this.at[i] = Math.min(Math.max(this.at[i], ranges[i][0]), ranges[i][1]);
    const same = this.both?.every((field, i) => Number(field.input.min) === ranges[i]![0] && Number(field.input.max) === ranges[i]![1]);
    if (!same) {
      const one = (i: 0 | 1, label: string) =>
        slider({ label, unit: "rad", value: this.at[i], min: ranges[i][0], max: ranges[i][1] }, (value) => this.move(i, value));
      this.both = [one(0, "Tool at u"), one(1, "Tool at θ")];
      this.sliders.replaceChildren(...this.both.map(({ root }) => root));
    }
    this.both?.forEach((field, i) => (field.value = this.at[i]!));
  }

  private move(i: 0 | 1, value: number): void {
    this.at[i] = value;
    void this.tool().catch((error: unknown) => this.desk.fail(error));
    // The fixed parameter moves the curves, the other one the cursor.
    if ((this.line === "theta") === (i === 0)) {
      this.soonLines();
      this.soonErrors();
    } else this.curves.show(value);
  }

  /** The cursor of a plot was moved. */
  private cursor(value: number): void {
    const i = this.line === "theta" ? 1 : 0;
    this.at[i] = value;
    if (this.both) this.both[i].value = value;
    void this.tool().catch((error: unknown) => this.desk.fail(error));
  }

  private async tool(): Promise<void> {
    const { outline } = this;
    if (!outline) return;
    const token = ++this.moves;
    const tool = JSON.parse(await this.desk.bench.call("helicoid_tool", request(this.inputs), JSON.stringify(this.limits), ...this.at)) as Tool;
    if (token !== this.moves) return;
    this.live.replaceChildren(displacements(tool, this.limits), place(tool));
    await this.picture.tool(this.inputs, outline, tool);
  }

  private held(): number {
    return this.line === "theta" ? this.at[0] : this.at[1];
  }

  private async lines(): Promise<void> {
    await this.curves.set(this.inputs, this.limits, this.line, this.held());
    this.curves.show(this.line === "theta" ? this.at[1] : this.at[0]);
  }

  private async errors(): Promise<void> {
    await this.flank.set(this.inputs, this.line, this.held());
  }

  state(): State {
    return { inputs: this.inputs, at: this.at, line: this.line, travel: this.travel.state() };
  }

  async open(state: Partial<State>): Promise<void> {
    this.inputs = { ...structuredClone(START), ...state.inputs };
    this.at = state.at ?? this.at;
    this.line = state.line ?? this.line;
    this.travel.open(state.travel as never);
    await this.start();
  }
}

let shown: Window | undefined;

export const view: View = {
  id: "helicoid",
  title: "Helicoid and five axes",
  build: async (root, desk) => {
    shown = new Window(root, desk);
    await shown.start();
  },
  state: () => shown?.state() ?? {},
  open: async (state) => {
    await shown?.open(state as Partial<State>);
  },
};
