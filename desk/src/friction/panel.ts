// Recorded circles: the effect of friction at the reversals, the identified friction, and the circles simulated with it.

import type { Desk } from "../core/desk";
import { button, choice, commandLine, el, section } from "../core/dom";
import { onDrop, save } from "../core/files";
import { fixed, significant } from "../core/number";
import { Samples } from "../core/sample";
import { word } from "../core/shell";
import { showTrace } from "./curves";
import type { Found, RecordRead, Trace } from "./documents";
import { Results } from "./results";
import { AXES_OF, PLANE_OF, Source, simulator, type Axes, type Circles, type Settings } from "./source";
import { Stopped, Work } from "./work";

type Drives = "found" | "machine";

export interface ViewState {
  axes: Axes;
  circles: Circles;
  drives: Drives;
  /** Whether the record was simulated. A dropped one is too large for a link: the user must drop it again. */
  simulated: boolean;
  fitted: boolean;
}

interface Record {
  name: string;
  axes: Axes;
  simulated: boolean;
}

const pair = (axes: Axes) => axes.split(",") as [string, string];

export class Friction {
  private readonly work: Work;
  private readonly source: Source;
  private readonly status = el("span", { role: "status" });
  private readonly bar = el("progress", { max: 1, value: 0, "aria-label": "Simulated", hidden: true });
  private readonly command = commandLine("The same on the command line:");
  private readonly results: Results;
  private readonly drives;
  private readonly find: HTMLButtonElement;
  private readonly plot = el("div");
  private readonly samples = new Samples([]);
  private record: Record | undefined;
  private found: Found | undefined;
  private busy = false;

  constructor(root: HTMLElement, private readonly desk: Desk, usual: Settings) {
    this.work = new Work(desk);
    const { work } = this;
    this.source = new Source(
      {
        record: (name, text, axes) => void this.run(() => this.read(name, text, axes)),
        simulate: () => void this.run(() => this.simulate()),
        stop: () => work.stop(),
        save: () => void this.run(async () => save("record.csv", await work.csv(), "text/csv")),
        changed: () => this.describe(),
        failed: desk.fail,
      },
      usual,
    );
    this.drives = choice<Drives>("Figures of the drives", [["found", "found in the record too"], ["machine", "those that the machine states"]], "found", () => this.describe());
    this.find = button("Find friction", () => void this.run(() => this.fit()), { class: "primary", disabled: true });
    this.results = new Results({
      copied: (done) => void done.then(() => desk.note("Settings copied."), desk.fail),
      merge: () => void this.run(() => this.merge()),
      simulate: () => void this.run(() => this.close()),
    });
    const row = el("div", { class: "row" }, this.drives.root, this.find, this.bar, this.status);
    root.append(section("Record", this.source.root, this.samples.root, this.plot, row, this.command.root), this.results.root, this.results.closed);
    onDrop(root, (files) => this.source.take(files), desk.fail);
    desk.machine.subscribe(() => this.describe());
    desk.runs.onRestart(() => this.forget("The record was lost with the computation: drop or simulate it again."));
    this.describe();
  }

  /** Runs one request; others wait until it is done. */
  private async run(request: () => Promise<void>): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    this.desk.clear();
    this.enable();
    try {
      await request();
    } catch (error) {
      if (error instanceof Stopped) this.status.textContent = "Stopped.";
      else {
        this.status.textContent = "";
        this.desk.fail(error);
      }
    } finally {
      this.busy = false;
      this.bar.hidden = true;
      this.enable();
      this.describe();
    }
  }

  private enable(simulating = false): void {
    this.find.disabled = this.busy || !this.record;
    this.results.enable(!this.busy && this.found !== undefined);
    this.source.enable({ busy: this.busy, simulating, simulated: this.record?.simulated ?? false });
  }

  private forget(why: string): void {
    this.record = this.found = undefined;
    this.samples.shown = false;
    this.status.textContent = why;
    this.plot.replaceChildren();
    this.results.clear();
    this.enable();
  }

  private async read(name: string, text: string, axes: Axes): Promise<void> {
    this.status.textContent = `Reading ${name} …`;
    const [read, trace] = await this.work.read(name, text, axes);
    this.source.circles.plane = PLANE_OF[axes];
    this.take({ name, axes, simulated: false }, read, trace);
  }

  private async simulate(): Promise<void> {
    await this.pass("record", "Simulating the circles");
    const [read, trace] = await this.work.simulated();
    this.take({ name: "record.csv", axes: AXES_OF[this.source.circles.plane], simulated: true }, read, trace);
  }

  private async pass(which: "record" | "before" | "after", what: string): Promise<void> {
    this.status.textContent = `${what} …`;
    this.bar.value = 0;
    this.bar.hidden = false;
    this.enable(true);
    await this.work.simulate(this.source.circles, which, (share) => {
      this.bar.value = share;
      this.status.textContent = `${what}, ${fixed(100 * share, 0)} %`;
    });
    this.enable();
  }

  private take(record: Record, read: RecordRead, trace: Trace): void {
    this.record = record;
    this.samples.shown = record.simulated;
    this.found = undefined;
    this.results.clear();
    showTrace(this.plot, record.simulated ? "the simulated record" : record.name, pair(record.axes), trace);
    const size = `${read.samples} samples at ${significant(1 / read.period_s, 4)} Hz`;
    this.status.textContent = [`${record.simulated ? "Simulated" : record.name}: ${size}.`, ...read.notes].join(" ");
  }

  private async fit(): Promise<void> {
    this.status.textContent = "Fitting …";
    const progress = (text: string) => (this.status.textContent = `Fitting ${text}`);
    this.found = await this.work.fit(this.drives.value === "found", progress);
    this.results.show(this.found);
    const left = this.found.largest.map(([axis, [before, after]]) => `${axis} ${significant(before, 3)} → ${significant(after, 3)} µm`);
    this.status.textContent = `Found. Largest spike, recorded → expected: ${left.join(", ")}.`;
  }

  private async close(): Promise<void> {
    if (!this.record?.simulated) await this.pass("before", "Simulating the circles without the figures");
    await this.pass("after", "Simulating the circles with the figures");
    this.status.textContent = "Evaluating …";
    const closed = await this.work.closed();
    this.results.showClosed(closed);
    this.status.textContent = "Simulated with the figures found.";
  }

  private async merge(): Promise<void> {
    if (!this.found) return;
    const { changes, notes } = await this.work.merge();
    if (changes) this.desk.note(`Friction put into ${this.desk.machine.name}: every view uses it now. Undo, above, takes it back; Save machine exports it.`);
    const done = changes ? `In ${this.desk.machine.name}'s machine.toml now.` : `Nothing of ${this.desk.machine.name} changes.`;
    this.status.textContent = [done, ...notes].join(" ");
  }

  /** The command line of the result shown. */
  private describe(): void {
    const find = this.drives.value === "found";
    const { name } = this.desk.machine;
    if (this.record && !this.record.simulated) {
      const machine = find ? "" : ` --machine ${word(name)}`;
      this.command.set(`trueaxis friction ${word(this.record.name)} --axes ${this.record.axes}${machine} -o friction.toml`);
    } else this.command.set(simulator(this.source.circles, name, find));
  }

  state(): ViewState {
    const { axes, circles } = this.source;
    return { axes, circles, drives: this.drives.value, simulated: this.record?.simulated ?? false, fitted: this.found !== undefined };
  }

  async open({ axes, circles, drives, simulated, fitted }: ViewState): Promise<void> {
    this.work.stop();
    await this.idle();
    this.source.open(axes, circles);
    this.drives.value = drives;
    this.describe();
    if (!simulated) return this.forget("The record was a file: drop it again.");
    await this.run(() => this.simulate());
    if (fitted) await this.run(() => this.fit());
  }

  /** Shows something at the start. */
  begin(): void {
    if (!this.record) void this.run(() => this.simulate());
  }

  private async idle(): Promise<void> {
    while (this.busy) await new Promise((done) => setTimeout(done, 20));
  }
}
