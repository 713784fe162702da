// A part before it is cut: its features in the colour of their verdict, and the part moved about the machine.

import partText from "../../../records/plate/part.toml";
import programText from "../../../records/plate/plate.ngc";
import { message, type Desk } from "../core/desk";
import { commandLine, debounce, el, numberField, section, slider, type Field } from "../core/dom";
import { onDrop, picker, type Given } from "../core/files";
import { significant } from "../core/number";
import { FIRST_MACHINE, Samples } from "../core/sample";
import { word } from "../core/shell";
import { Sentence, showTables, tabled } from "../core/shown";
import type { Vector } from "../core/space";
import { titled, type Kept, type Predicted, type Request, type There } from "./documents";
import { Files, NO_FILES } from "./files";
import { Longer } from "./longer";
import { Picture } from "./picture";
import { Features } from "./table";
import { Temperature } from "./temperature";

export interface ViewState {
  /** No part was open if null. */
  request: Request | null;
  sample: boolean;
}

/** Draws in the page; the command line has 10,000. */
const TRIALS = 1000;
const NOTHING = "Drop a part.toml with its program, and the machine's folder unless it is the machine shown.";
const SAMPLE: Request = { ...NO_FILES, part: ["part.toml", partText], program: ["plate.ngc", programText], trials: TRIALS, seed: 1 };
/** Time without a move after which the part is predicted at its new place, ms. */
const REST_MS = 600;
/** Ends of the sliders that differ by rounding. */
const SAME_MM = 1e-6;
/** Temperatures of workshops. */
const [COLDEST_C, WARMEST_C] = [5, 45];

export class Part {
  private request: Request | undefined;
  private isSample = false;
  private found: Predicted | undefined;
  /** Counts the predictions, so that a late response is discarded. */
  private latest = 0;
  /** What the last prediction was asked with. */
  private asked = "";
  /** The place that the sliders ask for while another one is computed. */
  private wanted: [at: Vector, celsius: number | undefined] | undefined;
  private isMoving = false;
  private chosen = 0;
  private kept: Kept | undefined;
  private sliders: Field[] = [];
  private readonly fields: Record<"trials" | "seed", Field>;
  private readonly files: Files;
  private readonly longer: Longer;
  private readonly temperature = new Temperature(
    (start) => this.change({ start }),
    () => this.change({ thermal: null, record: null, start: "" }),
  );
  private readonly samples = new Samples([["Try a sample", () => this.trySample()]]);
  private readonly status = el("p", { role: "status" });
  private readonly command = commandLine("The same on the command line:");
  private readonly sentence = new Sentence();
  private readonly picture = new Picture();
  private readonly features = new Features((index) => this.choose(index));
  private readonly place = el("div", { class: "place" });
  private readonly moved = el("p", { role: "status", class: "said" });
  private readonly budget = el("div", { class: "figures" });
  private readonly notes = el("div", { class: "figures" });
  private readonly results: HTMLElement;
  // Files dropped with their machine are predicted at once: its change asks for the same again, which would cancel what runs.
  private readonly soon = debounce(250, () => this.asked !== this.asking && void this.predict());
  private readonly rest = debounce(REST_MS, () => void this.predict());

  constructor(
    root: HTMLElement,
    private readonly desk: Desk,
  ) {
    const open = (given: Given[]) => void this.take(given).catch(desk.fail);
    const field = (label: string, key: "trials" | "seed", min: number, max: number) =>
      numberField({ label, value: SAMPLE[key], min, max, step: 1 }, (value) => {
        if (this.request) this.request[key] = value;
        this.soon();
      });
    this.fields = { trials: field("Machines drawn", "trials", 200, 100_000), seed: field("Seed", "seed", 0, Number.MAX_SAFE_INTEGER) };
    this.files = new Files(desk);
    this.longer = new Longer(desk, () => this.request, (option) => this.request && this.describe(this.request, option), (found) => {
      this.found = found;
      this.say(found);
      this.show(found);
      this.explain();
    });
    this.results = el(
      "div",
      { hidden: true },
      this.sentence.root,
      this.longer.root,
      el("div", { class: "columns" }, section("Features", this.picture.root), section("Place of the program's zero, temperature of the machine", this.place, this.moved, this.budget)),
      section("Tolerances", this.features.root, this.notes),
      this.longer.advice,
    );
    root.append(
      section(
        "Part before it is cut",
        el("p", {}, "The program runs on the exact geometry of the machine; the features of the part are fitted to what it cuts, and compared with their tolerances. The growth is that of machine.toml, or of a thermal.toml; a record of temperatures says how warm the machine is while it cuts. Bending and process are not included."),
        el("div", { class: "row" }, picker("Open part, programs, machine or temperatures", { accept: ".toml,.ngc,.nc,.gcode,.tap,.csv,.txt", several: true }, open, desk.fail), ...Object.values(this.fields).map(({ root }) => root)),
        this.samples.root,
        this.temperature.root,
        this.status,
        this.command.root,
      ),
      this.results,
    );
    onDrop(root, open, desk.fail);
    desk.machine.subscribe(this.soon);
    this.status.textContent = NOTHING;
    if (desk.machine.name === FIRST_MACHINE) this.trySample();
  }

  get state(): ViewState {
    return { request: structuredClone(this.request ?? null), sample: this.isSample };
  }

  open({ request, sample }: ViewState): void {
    if (!request) return this.nothing(NOTHING);
    this.found = this.wanted = undefined;
    this.results.hidden = true;
    this.request = structuredClone(request);
    this.isSample = sample;
    for (const key of ["trials", "seed"] as const) this.fields[key].value = request[key];
    void this.predict();
  }

  private change(change: Partial<Request>): void {
    if (!this.request) return;
    Object.assign(this.request, change);
    this.soon();
  }

  private trySample(): void {
    this.open({ request: { ...SAMPLE, ...this.draws }, sample: true });
  }

  /** What a prediction depends on. */
  private get asking(): string {
    return JSON.stringify([this.desk.machine.json, this.request]);
  }

  private get draws(): Pick<Request, "trials" | "seed"> {
    return { trials: this.fields.trials.value, seed: this.fields.seed.value };
  }

  private async take(given: Given[]): Promise<void> {
    const taken = await this.files.take(given, this.request, this.isSample, this.draws);
    if (typeof taken === "string") this.nothing(taken);
    else if (taken) this.open(taken);
  }

  private nothing(why: string): void {
    this.latest += 1;
    this.request = undefined;
    this.samples.shown = this.isSample = false;
    this.results.hidden = true;
    this.longer.forget();
    this.temperature.set({});
    this.status.textContent = why;
  }

  /** Predicts the part where it is, and keeps it to be moved from there. */
  private async predict(): Promise<void> {
    const { desk, request } = this;
    if (!request) return;
    const turn = ++this.latest;
    this.asked = this.asking;
    this.samples.shown = this.isSample;
    this.longer.forget();
    this.temperature.set(request);
    this.describe(request);
    this.status.textContent = `Predicting ${request.part[0]} …`;
    try {
      const asked = JSON.stringify(request);
      const [said, keep] = await Promise.all([desk.runs.call("predict", desk.machine.json, asked), desk.bench.call("predict_keep", desk.machine.json, asked)]);
      if (turn !== this.latest) return;
      const before = this.found?.document.features[this.chosen];
      const chosen = before && titled(before);
      this.found = JSON.parse(said) as Predicted;
      this.kept = JSON.parse(keep) as Kept;
      desk.clear();
      this.say(this.found);
      this.results.hidden = false;
      this.moved.textContent = "";
      this.sliding(this.found.document.at_mm);
      const { features } = this.found.document;
      const own = features[this.chosen];
      const kept = own && titled(own) === chosen ? this.chosen : features.findIndex((of) => titled(of) === chosen);
      this.chosen = kept >= 0 ? kept : this.found.used.indexOf(Math.max(...this.found.used));
      this.show(this.found);
      this.explain();
    } catch (error) {
      if (turn !== this.latest) return;
      this.status.textContent = `${request.part[0]} could not be predicted on ${desk.machine.name}.`;
      this.results.hidden = true;
      // A sample that does not suit the machine is no error of the user.
      if (this.isSample && !request.thermal && !request.record) this.status.textContent += ` ${message(error)}`;
      else desk.fail(error);
    }
  }

  private say({ shown, notes }: Predicted): void {
    this.status.textContent = [`${shown.summary.join(", ")}.`, ...notes].join(" ");
    this.sentence.set(shown.result);
    showTables(this.notes, { ...shown, tables: [] });
  }

  private show({ document, used, shapes }: There): void {
    this.picture.set(shapes, document.features[this.chosen]?.feature ?? "");
    this.features.set(document.features, used, this.chosen);
  }

  private choose(index: number): void {
    this.chosen = index;
    if (this.found) this.show(this.found);
    this.explain();
  }

  /** The budget of the chosen characteristic. */
  private explain(): void {
    const of = this.found?.document.features[this.chosen];
    const budget = of?.budget ?? [];
    if (!of || budget.length === 0) {
      this.budget.replaceChildren();
      return;
    }
    const rows = budget.slice(0, 12).map(({ term, standard_um, share }) => [term, { text: significant(100 * share, 3), value: 100 * share }, { text: significant(standard_um, 3), value: standard_um }]);
    this.budget.replaceChildren(tabled({ caption: `Budget of ${titled(of)}`, header: ["term", "share, %", "standard uncertainty, µm"], rows, bars: 1 }));
  }

  /** Sliders over the travel that the part leaves, and of the temperature of a machine that grows. */
  private sliding(at: Vector): void {
    if (!this.kept) return;
    const { range_mm: range, machine_c: celsius } = this.kept;
    const same = this.sliders.length === (celsius === null ? 3 : 4) && this.sliders.slice(0, 3).every(({ input }, k) => Math.abs(Number(input.min) - range[k]![0]) < SAME_MM && Math.abs(Number(input.max) - range[k]![1]) < SAME_MM);
    if (!same) {
      this.sliders = ["X", "Y", "Z"].map((label, k) => slider({ label, unit: "mm", value: at[k]!, min: range[k]![0], max: range[k]![1] }, () => this.move()));
      if (celsius !== null) this.sliders.push(slider({ label: "Machine", unit: "°C", value: celsius, min: COLDEST_C, max: WARMEST_C }, () => this.move()));
      this.place.replaceChildren(...this.sliders.map(({ root }) => root));
    }
    this.sliders.forEach((field, k) => (field.value = at[k] ?? celsius!));
  }

  private move(): void {
    const [x, y, z, celsius] = this.sliders.map(({ value }) => value);
    const at = [x, y, z] as Vector;
    if (this.request) {
      this.request.at_mm = at;
      // A machine that stays as warm as it is needs no model of its growth.
      if (celsius !== this.kept?.machine_c) this.request.machine_c = celsius ?? null;
    }
    // An earlier prediction would bring the part back.
    this.latest += 1;
    this.longer.forget();
    this.wanted = [at, this.request?.machine_c ?? undefined];
    void this.follow();
    this.rest();
  }

  /** One place after the other, the last one asked for first. */
  private async follow(): Promise<void> {
    if (this.isMoving) return;
    this.isMoving = true;
    try {
      while (this.wanted) {
        const [[at, celsius], turn] = [this.wanted, this.latest];
        this.wanted = undefined;
        const there = JSON.parse(await this.desk.bench.call("predict_at", ...at, celsius)) as There;
        const { found } = this;
        if (!found || (turn !== this.latest && !this.wanted)) continue;
        const features = there.document.features.map((of, k) => ({ ...of, budget: found.document.features[k]?.budget ?? [] }));
        this.found = { ...found, ...there, document: { ...there.document, features } };
        this.moved.textContent = "While it moves: exact values, the scatter of the place before. At rest it is predicted anew.";
        this.sentence.set("At another place: the verdicts are in the table.");
        this.show(this.found);
      }
    } catch (error) {
      this.desk.fail(error);
    } finally {
      this.isMoving = false;
    }
  }

  private describe({ part: [name], program: [program], thermal, record, start, at_mm, machine_c, trials, seed }: Request, option = ""): void {
    const machine = word(this.desk.machine.name);
    const number = (q: number) => significant(q, 6).replace("−", "-");
    const changes = [at_mm ? `at_mm = [${at_mm.map(number).join(", ")}]` : [], typeof machine_c === "number" ? `temperature.machine_c = ${number(machine_c)}` : []].flat();
    const places = [changes.length > 0 ? `${changes.join(" and ")} in ${name}` : [], thermal ? `${thermal[0]} beside machine.toml` : []].flat();
    const comment = places.length > 0 ? ` # with ${places.join(", ")}` : "";
    const at = start?.trim() ? ` --${start.includes(":") ? "at" : "start"} ${word(start.trim())}` : "";
    const options = [record ? `--thermal ${word(record[0])}${at}` : [], option === "" ? [] : option].flat().map((one) => ` ${one}`).join("");
    this.command.set(`trueaxis predict ${machine} ${word(name)} --program ${word(program)} --trials ${trials} --seed ${seed}${options}${comment}`);
  }
}
