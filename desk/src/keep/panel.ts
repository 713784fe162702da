// Balls that stay on the machine: planning a re-probing, checking its log against the history, updating the machine.

import begin from "../../../records/probing/begin.log";
import task from "../../../records/probing/keep.toml";
import look from "../../../records/probing/look.log";
import machine from "../../../records/probing/mill/machine.toml";
import { Probing, type ViewState as Task, type Log } from "../calibrate/probing";
import type { Desk } from "../core/desk";
import { button, el, section, textField, tick, warnings } from "../core/dom";
import { plain, save } from "../core/files";
import { clearest } from "../core/sentence";
import { word } from "../core/shell";
import { Sentence, showTables, tabled } from "../core/shown";
import type { Evaluated } from "./documents";
import { SAMPLE } from "./sample";

export interface ViewState extends Task {
  history: string;
}

const WORDS = {
  plan: "keep_plan",
  command: "keep",
  task: "keep.toml",
  program: "look.ngc",
  sample: SAMPLE,
  label: "Machine, probe, balls that stay in place, and the terms that may change, with their bounds",
  hint: "or drop them: keep.toml; machine.toml with its tables, unless it is the machine shown; thermal.toml; keep/history.jsonl; the log of a re-probing",
  accept: ".toml,.csv,.log,.txt,.jsonl",
  what: "Updates of the re-probing",
  without: "Run the program between parts, with the compensation on; then open the control's log here. Rehearse simulates it: at first of the machine as it is, later of one that has moved within its uncertainties. Or try a sample: the first log of another mill, with its task.",
  tried: [
    ["Try a sample", { "keep.toml": task, "machine.toml": machine, "begin.log": begin }],
    ["Try a later log of it", { "look.log": look }],
  ],
} as const;

export class Keep extends Probing {
  private history = "";
  private evaluated: Evaluated | undefined;
  /** Whether the history contains the re-probing shown. */
  private entered = false;
  private readonly results: HTMLElement;
  private readonly time: HTMLInputElement;
  private readonly parts: HTMLInputElement;
  private readonly accept: HTMLInputElement;
  private readonly byHand: HTMLInputElement;
  private readonly newHistory: HTMLInputElement;

  constructor(root: HTMLElement, desk: Desk) {
    const results = el("div", { hidden: true });
    const soon = () => this.soon();
    const time = textField("probed at, UTC", "2026-05-04T06:00:00Z", soon);
    const parts = textField("parts made until then", "0", soon, "number");
    const accept = textField("terms that may be out of their bounds", "offset X, C0Y", soon);
    const byHand = tick("accept tables that were changed by hand", false, soon);
    const newHistory = tick("a new history", false, soon);
    super(root, desk, WORDS, results, el("div", { class: "row" }, time.root, parts.root, accept.root, byHand.root, newHistory.root));
    this.results = results;
    [this.time, this.parts, this.accept, this.byHand, this.newHistory] = [time.input, parts.input, accept.input, byHand.input, newHistory.input];
    this.into.whenDone = () => this.enter();
    void this.work();
  }

  override get state(): ViewState {
    return { ...super.state, history: this.history };
  }

  override open(kept: ViewState): void {
    this.history = kept.history;
    this.entered = false;
    super.open(kept);
  }

  protected override takes(name: string, content: string): boolean {
    if (!name.endsWith(".jsonl")) return false;
    this.history = content;
    return true;
  }

  protected clear(): void {
    this.entered = false;
    this.results.hidden = true;
  }

  /** An entry stays visible until the next re-probing, so that its files can be saved. */
  protected override idle(): void {
    if (!this.entered) super.idle();
  }

  protected async found(turn: number, files: string, task: string, log: Log): Promise<void> {
    const { time, parts, accept } = this.given();
    const request = JSON.stringify({ history: this.history, begin: this.newHistory.checked, time: time || null, parts: parts === "" ? null : Number(parts), accept, by_hand: this.byHand.checked });
    try {
      const evaluated = JSON.parse(await this.desk.bench.call("keep_evaluate", files, this.name, task, log.name, log.text, request)) as Evaluated;
      if (!this.isLatest(turn) || this.log !== log) return;
      this.evaluated = evaluated;
      this.entered = false;
      this.desk.clear();
      const { machine, touches } = evaluated;
      this.solved.textContent = [`${log.name}: ${touches} touches on ${machine}.`, ...evaluated.notes].join(" ");
      this.show(evaluated);
      const { becomes } = evaluated;
      this.into.root.hidden = !becomes;
      if (becomes) this.into.show({ ...becomes, ...(this.own ? { own: { name: machine, files: this.own } } : {}) });
    } catch (error) {
      if (this.isLatest(turn) && this.log === log) this.fails(log, error);
    }
  }

  private given() {
    const accept = this.accept.value.split(",").map((name) => name.trim());
    return { time: this.time.value.trim(), parts: this.parts.value, accept: accept.filter((name) => name !== "") };
  }

  private show({ shown, refusal, becomes, entries, written }: Evaluated): void {
    const figures = el("div", { class: "figures" });
    showTables(figures, shown);
    figures.prepend(warnings(refusal ? [refusal] : []));
    const sentence = new Sentence();
    sentence.set(clearest(shown));
    // With updates, applying them below also enters them in the history.
    const enter = becomes || refusal ? [] : [button("Enter it in the history", () => this.enter(), { class: "primary" })];
    const saves = written.map(([name, content]) => button(`Save ${name}`, () => save(plain(name), content)));
    this.results.replaceChildren(
      sentence.root,
      section("Re-probing", figures),
      section("History", el("div", { class: "figures" }, tabled(entries)), el("div", { class: "row" }, ...enter, ...saves)),
    );
    this.results.hidden = false;
  }

  /** Enters the re-probing in the history: the next log is compared with it. */
  private enter(): void {
    if (!this.evaluated) return;
    const { history, log, own } = this;
    // Undo takes the entry out of the history too.
    this.into.whenUndone = () => {
      [this.history, this.log, this.own] = [history, log, own];
      this.entered = false;
      void this.work();
    };
    this.history = this.evaluated.history;
    const { entry } = this.evaluated;
    // The updated machine is now the one shown.
    if (this.evaluated.becomes) this.own = undefined;
    this.log = undefined;
    this.entered = true;
    this.newHistory.checked = false;
    this.solved.textContent = `Entry ${entry} is in the history: save it beside the machine's files, and open the log of the next re-probing.`;
    this.describe();
    for (const one of this.results.querySelectorAll<HTMLButtonElement>("button.primary")) one.disabled = true;
  }

  protected rehearsed(files: string, task: string): Promise<string> {
    return this.desk.bench.call("keep_rehearse", files, this.name, task, this.seed, !this.begins);
  }

  protected rehearsal(): string {
    return this.begins ? ` --machine ${word(this.desk.machine.name)}` : "";
  }

  /** Whether the next re-probing is the first of its history. */
  private get begins(): boolean {
    return this.history === "" || this.newHistory.checked;
  }

  protected command(task: string, log: string): string {
    const { time, parts, accept } = this.given();
    const said = (option: string, value: string) => (value === "" ? "" : ` ${option} ${word(value)}`);
    const begin = this.begins;
    const names = begin ? [] : accept.map((name) => said("--accept", name));
    const byHand = !begin && this.byHand.checked ? " --by-hand" : "";
    return `trueaxis keep ${begin ? "begin" : "check"} ${task} ${log}${said("--time", time)}${said("--parts", parts)}${names.join("")}${byHand}`;
  }
}
