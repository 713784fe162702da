// What takes longer than a prediction, in a worker of its own that can be cancelled: the servo, and what to measure.

import type { Bench, CallName } from "../core/bench";
import type { Desk } from "../core/desk";
import { button, el, section } from "../core/dom";
import { save } from "../core/files";
import { fixed } from "../core/number";
import { Sentence, showTables } from "../core/shown";
import type { Advised, Predicted, Request } from "./documents";

/** Servo rate, Hz: that of the command line. */
const RATE_HZ = 10_000;
class Cancelled extends Error {}

export class Longer {
  /** The buttons. */
  readonly root: HTMLElement;
  /** What to measure. */
  readonly advice: HTMLElement;
  private bench: Bench | undefined;
  private readonly starts: HTMLButtonElement[];
  private readonly end = button("Cancel", () => this.cancel(), { hidden: true });
  private readonly meter = el("progress", { max: 1, "aria-label": "Progress of the simulation", hidden: true });
  private readonly said = el("span", { role: "status", class: "said" });
  private readonly sentence = new Sentence();
  private readonly tables = el("div", { class: "figures" });
  private readonly task;
  private text = "";
  /** The button that was pressed. */
  private started = 0;

  /** `request` gives the part that is shown; `show` gets it with the servo, `begin` what the command line calls it. */
  constructor(
    private readonly desk: Desk,
    private readonly request: () => Request | undefined,
    private readonly begin: (option: string) => void,
    private readonly show: (found: Predicted) => void,
  ) {
    this.starts = [button("Simulate the servo", () => void this.follow()), button("What to measure", () => void this.advise())];
    this.task = button("Save task.toml", () => save("task.toml", this.text), { class: "primary" });
    this.root = el("div", { class: "row" }, ...this.starts, this.end, this.meter, this.said);
    this.advice = section("What to measure", this.sentence.root, el("div", { class: "row" }, this.task), this.tables);
    this.advice.hidden = true;
  }

  /** Forgets what belongs to a part that has changed. */
  forget(): void {
    this.cancel();
    this.advice.hidden = true;
  }

  private cancel(): void {
    if (this.end.hidden) return;
    this.bench?.close(new Cancelled());
    this.bench = undefined;
  }

  private async follow(): Promise<void> {
    const said = await this.run("predict_servo", "Simulating the servo", "--servo --exact-drives", RATE_HZ);
    if (said !== undefined) this.show(JSON.parse(said) as Predicted);
  }

  private async advise(): Promise<void> {
    const said = await this.run("predict_advise", "Comparing sets of measurements", "--advise -o task.toml", this.desk.machine.name);
    if (said === undefined) return;
    const { shown, task } = JSON.parse(said) as Advised;
    this.text = task ?? "";
    this.task.hidden = task === null;
    this.sentence.set(shown.result);
    showTables(this.tables, shown);
    this.advice.hidden = false;
  }

  private async run(name: CallName & ("predict_servo" | "predict_advise"), what: string, option: string, given: number | string): Promise<string | undefined> {
    const { desk } = this;
    const request = this.request();
    if (!request) return undefined;
    const bench = (this.bench ??= desk.spare());
    bench.onProgress = (share) => {
      this.meter.hidden = false;
      this.meter.value = Number(share);
      this.said.textContent = `${what}: ${fixed(100 * Number(share), 0)} %`;
    };
    this.running(true);
    this.said.textContent = `${what} …`;
    try {
      const call = bench.call as (name: string, ...given: unknown[]) => Promise<string>;
      const found = await call.call(bench, name, desk.machine.json, JSON.stringify(request), given);
      desk.clear();
      this.begin(option);
      return found;
    } catch (error) {
      if (!(error instanceof Cancelled)) desk.fail(error);
      return undefined;
    } finally {
      this.running(false);
    }
  }

  private running(is: boolean): void {
    const focus = document.activeElement;
    const own = this.starts.findIndex((start) => start === focus);
    if (own >= 0) this.started = own;
    const isHere = own >= 0 || focus === this.end;
    for (const start of this.starts) start.disabled = is;
    this.end.hidden = !is;
    if (isHere) (is ? this.end : this.starts[this.started]!).focus();
    this.meter.hidden = true;
    this.said.textContent = "";
  }
}
