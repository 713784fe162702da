// A record of a test with an instrument: the kind of test, its figures and curves, and the corrections written to the machine.

import { IntoMachine } from "../core/becomes";
import { message, type Desk } from "../core/desk";
import { choice, commandLine, debounce, el, group, section, table } from "../core/dom";
import { onDrop, picker, plainName, type Given } from "../core/files";
import { FIRST_MACHINE, Samples } from "../core/sample";
import { word } from "../core/shell";
import type { Evaluated, Test } from "./documents";
import { Results } from "./results";
import { SAMPLES, TESTS, type Option, type Value } from "./tests";

export interface ViewState {
  chosen: Test | "";
  options: Record<string, Value>;
  /** The sample shown, which a file need not contain. */
  sample?: Test;
}

const ALL = Object.entries(TESTS) as [Test, (typeof TESTS)[Test]][];

const WITHOUT = "Open a record, or drop one: its columns identify the test.";

export class Evaluate {
  private record: { name: string; bytes: Uint8Array; sample: Test | undefined } | undefined;
  /** A second record, dropped with the first, on which its errors are tested. */
  private against: { name: string; text: string } | undefined;
  /** Identified from the columns of the record. */
  private recognised: Test | undefined;
  private latest = 0;
  /** Files with which the results change the machine, to recognise that machine when it becomes the page's. */
  private offered = "";
  private readonly options = new Map<Test, Option[]>();
  private readonly groups = new Map<Test, HTMLElement>();
  private readonly chosen;
  private readonly status = el("p", { role: "status" }, WITHOUT);
  private readonly overview: HTMLElement;
  private readonly command = commandLine("The same on the command line:");
  private readonly samples = new Samples(ALL.filter(([test]) => SAMPLES[test]).map(([test, { title }]) => [`Try a sample: ${title}`, () => this.trySample(test)]));
  private readonly results = new Results();
  private readonly into: IntoMachine;

  constructor(
    root: HTMLElement,
    private readonly desk: Desk,
  ) {
    const again = () => void this.evaluate();
    const later = debounce(400, again);
    const soon = () => {
      // Corrections from the previous options must not be applied in the meantime.
      this.into.begin();
      later();
    };
    this.chosen = choice<Test | "">("Kind of test", [["", "as the record's columns show"], ...ALL.map(([test, { title }]) => [test, title] as const)], "", (kind) => this.choose(kind));
    for (const [test, { title, columns, about, options }] of ALL) {
      const own = options(soon);
      this.options.set(test, own);
      const rows = el("div", {}, ...[`Columns: ${columns}`, about].map((text) => el("small", {}, text)));
      this.groups.set(test, group(title, ...own.map((option) => option.root), rows));
    }
    this.overview = section("Records", table("Columns of a record", ["test", "columns; those in brackets may be left out", "rows and results"], ALL.map(([, { title, columns, about }]) => [title, columns, about])));
    this.into = new IntoMachine(desk, "Errors found by the test");
    this.into.root.hidden = true;
    const open = (given: Given[]) => this.take(given);
    root.append(
      section(
        "Record",
        el("div", { class: "row" }, picker("Open a record", { accept: ".csv,.txt" }, open, desk.fail), this.chosen.root, ...this.groups.values()),
        this.samples.root,
        this.status,
        this.command.root,
      ),
      this.results.root,
      this.into.root,
      this.overview,
    );
    onDrop(root, open, desk.fail);
    desk.machine.subscribe(() => {
      const { test } = this;
      // A machine that was corrected here comes back as a new machine; the results shown remain those of the original.
      if (test && TESTS[test].machine && desk.machine.json !== this.offered) again();
      else this.describe();
    });
    desk.bench.onRestart(() => this.nothing("The computation stopped; drop the record again."));
    this.describe();
    if (desk.machine.name === FIRST_MACHINE) this.trySample("step-diagonal");
  }

  get state(): ViewState {
    const all = [...this.options].flatMap(([test, own]) => own.map((option) => [`${test}.${option.key}`, option.kept()] as const));
    const { sample } = this.record ?? {};
    return { chosen: this.chosen.value, options: Object.fromEntries(all), ...(sample ? { sample } : {}) };
  }

  /** The state contains no record but a sample: the user must drop any other again. */
  open({ chosen, options, sample }: ViewState): void {
    this.chosen.value = chosen;
    for (const [test, own] of this.options) for (const option of own) option.open(options[`${test}.${option.key}`] ?? option.kept());
    this.record = this.recognised = this.against = undefined;
    if (sample && SAMPLES[sample]) this.trySample(sample);
    else this.nothing("The record was a file: drop it again.");
  }

  private get test(): Test | undefined {
    return this.chosen.value || this.recognised;
  }

  private take([file, second]: Given[]): void {
    if (!file) return;
    this.record = { name: plainName(file.path), bytes: file.bytes, sample: undefined };
    this.against = second && { name: plainName(second.path), text: new TextDecoder().decode(second.bytes) };
    this.recognised = undefined;
    void this.evaluate();
  }

  /** The user chose a kind of test: that of the record, or the sample to be shown. */
  private choose(kind: Test | ""): void {
    if (kind === "" || !this.record?.sample) void this.evaluate();
    else if (SAMPLES[kind]) this.trySample(kind);
    else {
      this.record = undefined;
      this.nothing(WITHOUT);
    }
  }

  private trySample(test: Test): void {
    const { name, text } = SAMPLES[test]!;
    if (this.chosen.value !== "") this.chosen.value = test;
    this.record = { name, bytes: new TextEncoder().encode(text), sample: test };
    this.against = undefined;
    this.recognised = undefined;
    void this.evaluate();
  }

  private nothing(why: string): void {
    this.latest += 1;
    this.status.textContent = why;
    this.samples.shown = this.record?.sample !== undefined;
    this.results.clear();
    this.into.root.hidden = true;
    this.describe();
  }

  private async evaluate(): Promise<void> {
    const { record, desk } = this;
    if (!record) {
      this.describe();
      return;
    }
    this.nothing(`Evaluating ${record.name} …`);
    const turn = this.latest;
    try {
      if (!this.test) this.recognised = (await desk.bench.call("evaluate_test", record.name, record.bytes)) as Test;
      const { test } = this;
      if (turn !== this.latest || !test) return;
      this.describe();
      const options = Object.fromEntries((this.options.get(test) ?? []).map((option) => [option.key, option.given()]));
      const request = test === "points" ? { ...options, against: this.against } : options;
      const said = await desk.bench.call("evaluate_record", test, desk.machine.json, record.name, record.bytes, JSON.stringify(request));
      if (turn !== this.latest) return;
      const { shown, becomes, notes } = JSON.parse(said) as Evaluated;
      desk.clear();
      const on = TESTS[test].machine ? [`on ${desk.machine.name}`] : [];
      this.status.textContent = [`${shown.title}, ${[record.name, ...shown.summary, ...on].join(", ")}.`, ...notes].join(" ");
      this.results.show(shown);
      this.into.begin();
      this.offered = JSON.stringify(becomes?.files);
      this.into.root.hidden = becomes === null;
      if (becomes) this.into.show(becomes);
    } catch (error) {
      if (turn !== this.latest) return;
      const on = this.test && TESTS[this.test].machine ? ` on ${desk.machine.name}, the machine shown` : "";
      this.status.textContent = `${record.name} could not be evaluated${on}.`;
      this.describe();
      // A sample that does not suit the machine is no error of the user.
      if (record.sample) this.status.textContent += ` ${message(error)}`;
      else desk.fail(error);
    }
  }

  /** Controls and command line of the test. */
  private describe(): void {
    const { test } = this;
    for (const [own, root] of this.groups) root.hidden = own !== test;
    this.overview.hidden = this.record !== undefined && !this.record.sample;
    this.command.root.hidden = test === undefined;
    if (!test) return;
    const name = word(this.desk.machine.name);
    const words = (this.options.get(test) ?? []).flatMap((option) => option.words());
    if (test === "points" && this.against) words.push("--against", word(this.against.name));
    const machine = TESTS[test].machine ? ["--machine", name, "-o", test === "points" ? `${name}-measured` : name] : [];
    this.command.set(["trueaxis evaluate", test, word(this.record?.name ?? "record.csv"), ...words, ...machine].join(" "));
  }
}
