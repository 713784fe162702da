// A probing task: its text, the machine, the planned program, the control's log.

import { IntoMachine } from "../core/becomes";
import { message, type Desk } from "../core/desk";
import { button, commandLine, debounce, el, notes, section, unique } from "../core/dom";
import { onDrop, picker, plainName, save, text, type Given } from "../core/files";
import type { Files } from "../core/machine";
import { significant } from "../core/number";
import { Samples } from "../core/sample";
import { word } from "../core/shell";
import { tabled } from "../core/shown";
import type { Table } from "../core/shown-types";
import type { Planned, Rehearsed } from "./documents";

export interface ViewState {
  name: string;
  task: string;
}

export interface Log {
  name: string;
  text: string;
}

/** Files of a task that has been run: task, machine, log. */
export type Sample = Readonly<Record<string, string>>;

/** Names and texts that differ between the kinds of task. */
export interface Words {
  /** The module's export, and the command. */
  plan: "calibrate_plan" | "keep_plan";
  command: string;
  /** Names of the files of task and program. */
  task: string;
  program: string;
  sample: string;
  /** The heading above the task, and the files that may be dropped. */
  label: string;
  hint: string;
  accept: string;
  /** Name of the result that the machine gets, and the text shown without a log. */
  what: string;
  without: string;
  /** Files opened by the button of the same text. */
  tried: readonly (readonly [button: string, files: Sample])[];
}

const DESCRIPTION = "machine.toml";

export abstract class Probing {
  protected name: string;
  /** A machine dropped with the task, such as one without tables; no other view shows it. */
  protected own: Files | undefined;
  protected log: Log | undefined;
  protected planned: Planned | undefined;
  /** Files that the task names beside the machine's. */
  private named: Files = {};
  private latest = 0;
  protected readonly task;
  private readonly about = el("p", { role: "status" });
  private readonly refused = el("p", { class: "warning", role: "alert", hidden: true });
  private readonly expected = el("div", { class: "figures" });
  private readonly program: HTMLButtonElement;
  private readonly plan = commandLine("The same on the command line:");
  protected readonly solve = commandLine("The same on the command line:");
  protected readonly solved = el("p", { role: "status" });
  private readonly samples: Samples;
  /** Draws the machine of a rehearsal; the next one gets another. */
  protected seed = 0;
  private readonly truth = el("div", { class: "figures", hidden: true });
  private readonly simulate = commandLine("The rehearsal on the command line:");
  private readonly saveLog: HTMLButtonElement;
  protected readonly into: IntoMachine;
  protected readonly soon = debounce(250, () => void this.work());

  constructor(
    root: HTMLElement,
    protected readonly desk: Desk,
    private readonly words: Words,
    results: HTMLElement,
    ...controls: HTMLElement[]
  ) {
    const { soon } = this;
    this.name = words.task;
    const id = unique("task");
    this.task = el("textarea", { id, rows: 26, spellcheck: "false", oninput: soon });
    this.task.value = words.sample;
    this.program = button("Save the program", () => this.planned && save(this.file, this.planned.program), { class: "primary", disabled: true });
    this.into = new IntoMachine(desk, words.what);
    this.into.root.hidden = true;
    const open = (given: Given[]) => this.take(given);
    this.saveLog = button("Save the log", () => this.log && save(this.log.name, this.log.text));
    const rehearse = button("Rehearse", () => void this.rehearse());
    this.samples = new Samples(words.tried.map(([button, files]) => [button, () => this.trySample(files)]), rehearse, this.saveLog);
    this.showTruth();
    root.append(
      section(
        "Task",
        el(
          "div",
          { class: "row" },
          picker("Open task, machine or log", { accept: words.accept, several: true }, open, desk.fail),
          button("Save the task", () => save(this.name, this.task.value)),
          el("small", {}, words.hint),
        ),
        el(
          "div",
          { class: "columns" },
          el("div", {}, el("label", { for: id }, words.label), this.task),
          el("div", {}, this.about, this.refused, this.expected, el("div", { class: "row" }, this.program)),
        ),
        this.plan.root,
      ),
      section("Log", ...controls, this.samples.root, this.solved, this.solve.root, this.simulate.root, this.truth),
      results,
      this.into.root,
    );
    onDrop(root, open, desk.fail);
    desk.machine.subscribe(() => {
      // Solving again would add the errors to the machine a second time.
      if (!this.own && !this.into.done) soon();
    });
  }

  /** Solves a log and shows the result, unless `turn` is no longer the latest. */
  protected abstract found(turn: number, files: string, task: string, log: Log): Promise<void>;
  protected abstract clear(): void;
  /** The module's answer to a rehearsal with the seed. */
  protected abstract rehearsed(files: string, task: string): Promise<string>;
  /** Options of the command that rehearses. */
  protected abstract rehearsal(): string;
  /** The command for a log, from the names of task and log. */
  protected abstract command(task: string, log: string): string;

  /** Offers a dropped file to a view that needs more files than the task; returns whether the view has kept it. */
  protected takes(_name: string, _content: string): boolean {
    return false;
  }

  get state(): ViewState {
    return { name: this.name, task: this.task.value };
  }

  /** The state contains no logs: the user must drop them again. */
  open({ name, task }: ViewState): void {
    this.name = name;
    this.task.value = task;
    this.own = this.log = undefined;
    this.named = {};
    void this.work();
  }

  private trySample(files: Sample): void {
    const encoder = new TextEncoder();
    this.take(Object.entries(files).map(([path, content]) => ({ path, bytes: encoder.encode(content) })));
    this.samples.shown = true;
  }

  /** Simulates the log of the task on a machine of drawn errors, and opens it. */
  private async rehearse(): Promise<void> {
    const turn = ++this.latest;
    this.seed += 1;
    const name = `rehearsed-${this.seed}.log`;
    try {
      const said = await this.rehearsed(this.files, this.task.value);
      if (!this.isLatest(turn)) return;
      const { log, truth } = JSON.parse(said) as Rehearsed;
      this.log = { name, text: log };
      this.desk.clear();
      this.samples.say("Rehearsed");
      this.simulate.set(`trueaxis ${this.words.command} simulate ${word(this.name)}${this.rehearsal()} --seed ${this.seed} -o ${name}`);
      this.showTruth(truth);
      void this.work();
    } catch (error) {
      if (this.isLatest(turn)) this.desk.fail(error);
    }
  }

  /** Shows what is true in a rehearsal, or nothing. */
  private showTruth(truth?: Table): void {
    this.truth.hidden = this.simulate.root.hidden = this.saveLog.hidden = truth === undefined;
    this.truth.replaceChildren(...(truth ? [tabled(truth)] : []));
  }

  private take(given: Given[]): void {
    this.samples.shown = false;
    this.showTruth();
    const texts = new Map<string, string>();
    for (const { path, bytes } of given) {
      const [name, content] = [plainName(path), text(bytes)];
      if (content === undefined) {
        this.desk.fail(new Error(`${name}: found bytes that are not UTF-8, needed a text`));
        return;
      }
      texts.set(name, content);
    }
    const machine = texts.get(DESCRIPTION);
    const files: Files = {};
    // A TOML file that another task names is not a task.
    const tasks = [this.task.value, ...[...texts].filter(([name]) => name.endsWith(".toml")).map(([, content]) => content)];
    for (const [name, content] of texts) {
      const named = (of: string | undefined) => of?.includes(`"${name}"`);
      if (name === DESCRIPTION || named(machine)) files[name] = content;
      else if (tasks.some(named)) this.named[name] = content;
      else if (name.endsWith(".toml")) [this.name, this.task.value] = [name, content];
      else if (!this.takes(name, content)) this.log = { name, text: content };
    }
    if (machine !== undefined) this.own = files;
    void this.work();
  }

  /** Shows that a log was refused. */
  protected fails(log: Log, error: unknown): void {
    this.solved.textContent = `${log.name} could not be evaluated.`;
    this.clear();
    this.into.root.hidden = true;
    this.desk.fail(error);
  }

  protected isLatest(turn: number): boolean {
    return turn === this.latest;
  }

  /** Texts of the machine, and of what the task names beside it. */
  private get files(): string {
    return JSON.stringify({ ...(this.own ?? this.desk.machine.files), ...this.named });
  }

  /** Plans the task, and solves the log if one is open. */
  protected async work(): Promise<void> {
    const turn = ++this.latest;
    this.into.begin();
    const { files } = this;
    const task = this.task.value;
    try {
      const planned = JSON.parse(await this.desk.bench.call(this.words.plan, files, this.name, task)) as Planned;
      if (turn !== this.latest) return;
      this.foresee(planned);
    } catch (error) {
      if (turn !== this.latest) return;
      this.planned = undefined;
      this.refused.hidden = false;
      this.refused.textContent = message(error);
      this.about.textContent = "";
      this.expected.replaceChildren();
    }
    this.program.disabled = !this.planned;
    this.describe();
    if (this.log) await this.found(turn, files, task, this.log);
    else this.idle();
  }

  /** Closes the log. */
  protected idle(): void {
    this.solved.textContent = this.words.without;
    this.samples.shown = false;
    this.showTruth();
    this.into.root.hidden = true;
    this.clear();
  }

  /** What a log holds. */
  protected get noun(): string {
    return this.planned?.is_sheet ? "readings" : "touches";
  }

  /** Name of the file of the program or sheet. */
  private get file(): string {
    return this.planned?.is_sheet ? "sheet.csv" : this.words.program;
  }

  private foresee(planned: Planned): void {
    this.planned = planned;
    this.refused.hidden = true;
    const { machine, touches, minutes, rank, condition, warnings } = planned.foreseen;
    const network = rank === undefined ? "." : ` without set-ups. Rank ${rank}, condition ${significant(condition ?? NaN, 2)}.`;
    this.about.textContent = [`${machine}: ${touches} ${this.noun}, about ${Math.ceil(minutes)} ${Math.ceil(minutes) === 1 ? "minute" : "minutes"}${network}`, ...planned.notes].join(" ");
    this.expected.replaceChildren(tabled(planned.expected), notes("Notes", warnings ?? []));
  }

  protected describe(): void {
    const task = word(this.name);
    this.plan.set(`trueaxis ${this.words.command} plan ${task} -o ${this.file}`);
    this.solve.set(this.command(task, word(this.log?.name ?? `trueaxis-${this.planned?.foreseen.program ?? "…"}.log`)));
  }
}
