// Roundness and spindle error from three probes, or a trace with its circles.

import "./style.css";
import type { Desk, View } from "../core/desk";
import { button, commandLine, debounce, el, section } from "../core/dom";
import { onDrop, picker, save, text, type Given } from "../core/files";
import { Samples } from "../core/sample";
import { word } from "../core/shell";
import { Angles } from "./angles";
import type { CircleName, Noted, Probes, Request } from "./documents";
import { Infeed, type GrindRequest } from "./infeed";
import { Polar } from "./polar";
import { Results } from "./results";
import { Settings } from "./settings";

/** Readings or a trace; without a text, those that the module simulates. */
interface Source {
  name: string;
  text?: string;
}

interface State {
  source: Source;
  request: Request;
  hidden: CircleName[];
  angles: { probes: Probes; count: number };
  infeed: { machine: "sample" | "desk"; request: GrindRequest };
}

class Roundnesses {
  private source: Source = { name: "" };
  private shownText = "";
  private latest = 0;
  private stale = false;
  private readonly settings: Settings;
  private readonly polar: Polar;
  private readonly results: Results;
  private readonly angles: Angles;
  private readonly infeed: Infeed;
  private readonly samples = new Samples([["Simulated readings", () => void this.begin()]]);
  private readonly command = commandLine("The same on the command line:");
  private readonly about = el("p", { role: "status", class: "about" });
  private readonly notes = el("ul", { class: "notes", "aria-label": "Warnings and notes" });

  constructor(
    root: HTMLElement,
    private readonly desk: Desk,
    private readonly sample: { name: string; text: string; request: Request },
  ) {
    const soon = debounce(80, () => void this.evaluate());
    this.settings = new Settings(sample.request, soon);
    this.polar = new Polar(desk, () => this.refresh());
    this.results = new Results(desk);
    this.infeed = new Infeed(desk);
    const use = (probes: Probes) => {
      this.settings.value = { ...this.settings.value, probes };
      soon();
    };
    this.angles = new Angles(desk, sample.request.probes, use, () => this.settings.value.probes);
    const open = (files: Given[]) => void this.take(files);
    const bar = el(
      "div",
      { class: "row" },
      picker("Open readings or a trace", { accept: ".csv,.txt" }, open, desk.fail),
      button("Save these readings", () => save(this.source.name, this.shownText, "text/csv")),
      el("span", { class: "said" }, "or drop a file here: h1_um,h2_um,h3_um of three probes, with or without theta_deg, or x_mm,y_mm of a trace"),
    );
    const found = el("div", { class: "found" }, this.about, this.notes, this.polar.ticks, this.results.tables);
    root.append(
      section("Readings", bar, this.samples.root, this.results.sentence.root, el("div", { class: "desk" }, this.settings.root, this.polar.root, found), this.command.root),
      this.results.root,
      this.angles.root,
      this.infeed.root,
    );
    onDrop(root, open, desk.fail);
    desk.bench.onRestart(() => (this.stale = true));
  }

  get state(): State {
    const { source } = this;
    return { source, request: this.settings.value, hidden: this.polar.hidden, angles: this.angles.value, infeed: this.infeed.value };
  }

  async open(state: State): Promise<void> {
    this.source = state.source;
    this.settings.value = state.request;
    this.polar.hidden = state.hidden;
    this.angles.value = state.angles;
    this.infeed.value = state.infeed;
    await this.evaluate();
  }

  /** The simulated readings with the settings that belong to them. */
  async begin(): Promise<void> {
    this.source = { name: this.sample.name };
    this.settings.value = this.sample.request;
    await this.evaluate();
  }

  /** Shows the state again after a restart of the module. */
  async refresh(): Promise<void> {
    if (this.stale) await this.evaluate();
  }

  private async take(files: Given[]): Promise<void> {
    const [file] = files;
    if (!file) return;
    const name = file.path.split("/").pop() ?? file.path;
    const content = text(file.bytes);
    if (content === undefined) this.desk.fail(new Error(`${name}: found bytes that are not UTF-8, needed a text`));
    else {
      this.source = { name, text: content };
      await this.evaluate();
    }
  }

  private async evaluate(): Promise<void> {
    const turn = ++this.latest;
    this.stale = false;
    const { name, text = this.sample.text } = this.source;
    this.shownText = text;
    this.samples.shown = this.source.text === undefined;
    // The header determines which of the two it is.
    const trace = /\bx_mm\b/.test(text.slice(0, 4096));
    this.command.set(trace ? `trueaxis circle ${word(name)} --json` : this.settings.command(name));
    try {
      const said = trace
        ? await this.desk.bench.call("roundness_trace", name, text)
        : await this.desk.bench.call("roundness_evaluate", name, text, JSON.stringify(this.settings.value));
      if (turn !== this.latest) return;
      // A response makes an earlier refusal obsolete at once, before its last plot is drawn.
      this.desk.clear();
      await this.show(said);
    } catch (error) {
      if (turn !== this.latest) return;
      this.about.textContent = `${name} could not be evaluated.`;
      this.notes.replaceChildren();
      this.results.clear();
      this.polar.clear();
      this.desk.fail(error);
    }
  }

  private async show(said: string): Promise<void> {
    const { warnings, shown, notes } = JSON.parse(said) as Noted;
    this.say(shown.summary.join(", "), notes, warnings);
    await this.polar.draw();
    await this.results.show(shown);
  }

  private say(what: string, notes: string[], warnings: string[]): void {
    const simulated = this.source.text === undefined ? ", simulated" : "";
    this.about.textContent = `${this.source.name}${simulated}: ${what}`;
    const lines = [...warnings.map((line) => el("li", { class: "warning" }, `warning: ${line}`)), ...notes.map((line) => el("li", {}, `note: ${line}`))];
    this.notes.replaceChildren(...lines);
  }
}

let shown: Roundnesses | undefined;

export const view: View = {
  id: "roundness",
  title: "Roundness",
  async build(root, desk) {
    const sample = JSON.parse(await desk.bench.call("roundness_sample")) as { name: string; text: string; request: Request };
    shown = new Roundnesses(root, desk, sample);
    await shown.begin();
  },
  shown: () => void shown?.refresh(),
  state: () => shown?.state,
  open: async (state) => {
    const kept = state as Partial<State> | null;
    if (!kept?.source || !kept.request || !kept.hidden || !kept.angles || !kept.infeed) throw new Error("roundness: found a state without readings and settings, needed one that this page saved");
    await shown?.open(kept as State);
  },
};
