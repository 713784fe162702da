// Uncertainty of the machine's corrected position.

import { type Desk } from "../core/desk";
import { commandLine, debounce, el, textField, numberField, section, typed } from "../core/dom";
import { significant } from "../core/number";
import { Plot } from "../core/plot";
import { largestShare } from "../core/sentence";
import { word } from "../core/shell";
import { Sentence, showTables } from "../core/shown";
import type { Known, Request } from "./documents";

export interface ViewState {
  request: Request;
  at: string;
}

export class Position {
  private request: Request = { at: [], points: 9, confidence_percent: 95, trials: 2000, seed: 1 };
  private latest = 0;
  private readonly fields;
  private readonly at: HTMLInputElement;
  private readonly status = el("p", { role: "status" });
  private readonly command = commandLine("The same on the command line:");
  private readonly sentence = new Sentence();
  private readonly tables = el("div", { class: "figures" });
  private readonly plots = el("div");
  private readonly results: HTMLElement;

  constructor(
    root: HTMLElement,
    private readonly desk: Desk,
  ) {
    const soon = debounce(250, () => void this.evaluate());
    const field = (label: string, key: Exclude<keyof Request, "at">, min: number, max: number, unit?: string) =>
      numberField({ label, value: this.request[key], min, max, ...(unit ? { unit } : {}), ...(key === "confidence_percent" ? {} : { step: 1 }) }, (value) => {
        this.request[key] = value;
        soon();
      });
    this.fields = {
      confidence_percent: field("Coverage", "confidence_percent", 50, 99.99, "%"),
      points: field("Points along each axis", "points", 2, 51),
      trials: field("Machines drawn", "trials", 100, 100_000),
      seed: field("Seed", "seed", 0, Number.MAX_SAFE_INTEGER),
    };
    const at = textField("Also at / mm, °", "X, Y, Z", soon);
    this.at = at.input;
    const fields = Object.values(this.fields).map(({ root }) => root);
    this.results = el("div", {}, this.sentence.root, el("div", { class: "columns" }, section("Largest uncertainty", this.plots), section("Figures", this.tables)));
    root.append(
      section(
        "Uncertainty of the corrected position",
        el("p", {}, "The machine.toml states how well tables and settings are known, as standard uncertainties, [uncertainty]. They are propagated to the tip by derivatives, and by machines drawn at random."),
        el("div", { class: "row" }, ...fields, at.root),
        this.status,
        this.command.root,
      ),
      this.results,
    );
    desk.machine.subscribe(soon);
    void this.evaluate();
  }

  get state(): ViewState {
    return { request: structuredClone(this.request), at: this.at.value };
  }

  open({ request, at }: ViewState): void {
    this.request = structuredClone(request);
    this.at.value = at;
    for (const [key, field] of Object.entries(this.fields)) field.value = request[key as keyof typeof this.fields];
    void this.evaluate();
  }

  private async evaluate(): Promise<void> {
    const turn = ++this.latest;
    const { desk, request } = this;
    const words = typed(this.at.value);
    request.at = words.map(Number);
    const { confidence_percent, points, trials, seed } = request;
    const at = words.length > 0 ? ` --at=${words.join(",")}` : "";
    this.command.set(`trueaxis uncertainty ${word(desk.machine.name)}${at} --confidence ${confidence_percent} --points ${points} --trials ${trials} --seed ${seed}`);
    this.status.textContent = "Evaluating …";
    try {
      const wrong = words.find((part) => !Number.isFinite(Number(part)));
      if (wrong !== undefined) throw new Error(`--at: found ${wrong}, needed numbers X,Y,Z`);
      const said = await desk.bench.call("uncertainty", desk.machine.json, JSON.stringify(request));
      if (turn !== this.latest) return;
      const known = JSON.parse(said) as Known;
      desk.clear();
      this.show(known);
    } catch (error) {
      if (turn !== this.latest) return;
      this.status.textContent = "This machine could not be evaluated.";
      this.results.hidden = true;
      // A machine that states no uncertainties is reported here, not as an error of the page.
      if (error instanceof Error && words.length === 0) this.status.textContent = error.message;
      else desk.fail(error);
    }
  }

  private show(known: Known): void {
    this.results.hidden = false;
    this.sentence.set(`The tip is known to ${significant(known.worst[1], 3)} µm at the worst point; ${largestShare(known.shown, "the squared uncertainty", "measure it better first")}`);
    this.status.textContent = [`${known.shown.summary.join(", ")}.`, ...known.notes].join(" ");
    this.draw(known);
    showTables(this.tables, known.shown);
  }

  private draw({ distances_um, worst: [place, radius] }: Known): void {
    this.plots.replaceChildren();
    const plot = new Plot(this.plots, {
      title: `Machines drawn whose tip lies within a distance, at ${place}`,
      x: "distance / µm",
      y: "share / %",
      height: 300,
      series: [{ name: "share of the machines", colour: "after", unit: "%" }],
    });
    const last = Math.max(1, distances_um.length - 1);
    plot.set([distances_um, distances_um.map((_, step) => (100 * step) / last)]);
    plot.mark([{ x: radius, text: `radius by derivatives ${significant(radius, 3)} µm` }]);
  }
}
