// From a task to a probing program, from its log to the errors of the machine.

import log from "../../../records/probing/probe.log";
import machine from "../../../records/probing/mill/machine.toml";
import task from "../../../records/probing/task.toml";
import type { Desk } from "../core/desk";
import { word } from "../core/shell";
import type { Found } from "./documents";
import { Probing, type Log } from "./probing";
import { Results } from "./results";
import { SAMPLE } from "./sample";

const WORDS = {
  plan: "calibrate_plan",
  command: "calibrate",
  task: "task.toml",
  program: "probe.ngc",
  sample: SAMPLE,
  label: "Machine, probe, artefacts and their places",
  hint: "or drop them: task.toml; machine.toml with its tables, unless it is the machine shown; the log of LinuxCNC, grblHAL, Klipper, or a CSV",
  accept: ".toml,.csv,.log,.txt",
  what: "Errors found by probing",
  without: "Run the program; then open the control's log here. Rehearse simulates it on a machine whose errors are drawn within the uncertainties of this one. Or try a sample: the log of another mill, with its task.",
  tried: [["Try a sample", { "task.toml": task, "machine.toml": machine, "probe.log": log }]],
} as const;

export class Calibrate extends Probing {
  private readonly results: Results;

  constructor(root: HTMLElement, desk: Desk) {
    const results = new Results();
    super(root, desk, WORDS, results.root);
    this.results = results;
    void this.work();
  }

  protected clear(): void {
    this.results.clear();
  }

  protected async found(turn: number, files: string, task: string, log: Log): Promise<void> {
    this.solved.textContent = `Solving ${log.name} …`;
    try {
      const said = await this.desk.bench.call("calibrate_solve", files, this.name, task, log.name, log.text);
      if (!this.isLatest(turn)) return;
      const found = JSON.parse(said) as Found;
      this.desk.clear();
      this.solved.textContent = [`${log.name}: ${found.touches} ${this.noun} on ${found.machine}.`, ...found.notes].join(" ");
      this.results.show(found);
      this.into.show({ ...found.becomes, ...(this.own ? { own: { name: found.machine, files: this.own } } : {}) });
      this.into.root.hidden = false;
    } catch (error) {
      if (!this.isLatest(turn)) return;
      this.fails(log, error);
    }
  }

  protected rehearsed(files: string, task: string): Promise<string> {
    return this.desk.bench.call("calibrate_rehearse", files, this.name, task, this.seed);
  }

  protected rehearsal(): string {
    return "";
  }

  protected command(task: string, log: string): string {
    return `trueaxis calibrate solve ${task} ${log} -o ${word(this.desk.machine.name)}`;
  }
}
