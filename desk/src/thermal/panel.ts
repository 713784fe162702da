// A recorded warm-up: sensor lags, growth curves, residuals of held-out cycles, the controller's file.

import { message, type Desk } from "../core/desk";
import { button, commandLine, debounce, el, textField, section, typed } from "../core/dom";
import { onDrop, picker, plainName, save, text, type Given } from "../core/files";
import { FIRST_MACHINE, Samples } from "../core/sample";
import { word } from "../core/shell";
import type { Fitted } from "./documents";
import { Results } from "./results";

export interface ViewState {
  holdOut: string;
  without: string;
  /** Whether the record is the sample, which a file need not contain. */
  sample?: boolean;
}

export class Growth {
  private record: { name: string; text: string; sample: boolean } | undefined;
  private fitted: Fitted | undefined;
  private latest = 0;
  private readonly holdOut: HTMLInputElement;
  private readonly without: HTMLInputElement;
  private readonly status = el("p", { role: "status" }, "Drop a record: one row a reading, t_s, cycle, T1_c … T16_c, spindle_rpm, ex_um, ey_um, ez_um, x_mm, y_mm, z_mm, tool_mm.");
  private readonly texts: HTMLButtonElement;
  private readonly file: HTMLButtonElement;
  private readonly command = commandLine("The same on the command line:");
  private readonly samples = new Samples([["Try a sample", () => this.trySample()]]);
  private readonly results = new Results();

  constructor(
    root: HTMLElement,
    private readonly desk: Desk,
  ) {
    const again = () => void this.fit();
    const soon = debounce(400, again);
    const holdOut = textField("Cycles held out of the fit", "the last", soon);
    const without = textField("Sensors to leave out", "none", soon);
    [this.holdOut, this.without] = [holdOut.input, without.input];
    const open = (given: Given[]) => this.take(given);
    this.texts = button("Save thermal.toml", () => this.fitted && save("thermal.toml", this.fitted.toml), { disabled: true });
    this.file = button("Save the controller's file", () => void this.compile().catch(desk.fail), { class: "primary", disabled: true });
    root.append(
      section(
        "Record",
        el("div", { class: "row" }, picker("Open a record", { accept: ".csv,.txt" }, open, desk.fail), holdOut.root, without.root),
        this.samples.root,
        this.status,
        el("div", { class: "row" }, this.texts, this.file),
        this.command.root,
      ),
      this.results.root,
    );
    onDrop(root, open, desk.fail);
    desk.machine.subscribe(again);
    this.describe();
    if (desk.machine.name === FIRST_MACHINE) this.trySample();
  }

  get state(): ViewState {
    return { holdOut: this.holdOut.value, without: this.without.value, ...(this.record?.sample ? { sample: true } : {}) };
  }

  /** The state contains no record but the sample: the user must drop any other again. */
  open({ holdOut, without, sample }: ViewState): void {
    [this.holdOut.value, this.without.value] = [holdOut, without];
    this.record = undefined;
    if (sample) this.trySample();
    else this.nothing("The record was a file: drop it again.");
  }

  private trySample(): void {
    const read = async () => {
      const turn = ++this.latest;
      const text = await this.desk.bench.call("thermal_sample");
      if (turn !== this.latest) return;
      this.record = { name: "warm-up.csv", text, sample: true };
      await this.fit();
    };
    read().catch(this.desk.fail);
  }

  private take([file]: Given[]): void {
    if (!file) return;
    const name = plainName(file.path);
    const content = text(file.bytes);
    if (content === undefined) {
      this.desk.fail(new Error(`${name}: found bytes that are not UTF-8, needed a text`));
      return;
    }
    this.record = { name, text: content, sample: false };
    void this.fit();
  }

  private nothing(why: string): void {
    this.latest += 1;
    this.fitted = undefined;
    this.texts.disabled = this.file.disabled = true;
    this.status.textContent = why;
    this.samples.shown = this.record?.sample ?? false;
    this.results.clear();
    this.describe();
  }

  private async fit(): Promise<void> {
    const { record, desk } = this;
    if (!record) {
      this.describe();
      return;
    }
    this.nothing(`Fitting ${record.name} …`);
    const turn = this.latest;
    const cycles = typed(this.holdOut.value).map(Number);
    try {
      const wrong = cycles.findIndex((cycle) => !Number.isInteger(cycle) || cycle < 0);
      if (wrong >= 0) throw new Error(`--hold-out: found ${typed(this.holdOut.value)[wrong]}, needed numbers of cycles`);
      const said = await desk.bench.call("thermal_fit", desk.machine.json, record.name, record.text, JSON.stringify({ hold_out: cycles, without: typed(this.without.value) }));
      if (turn !== this.latest) return;
      this.fitted = JSON.parse(said) as Fitted;
      desk.clear();
      this.status.textContent = [`${record.name}: ${this.fitted.shown.summary.join(", ")}, on ${desk.machine.name}.`, ...this.fitted.notes].join(" ");
      this.texts.disabled = this.file.disabled = false;
      this.results.show(this.fitted);
    } catch (error) {
      if (turn !== this.latest) return;
      this.status.textContent = `${record.name} could not be evaluated.`;
      // A sample that does not suit the machine is no error of the user.
      if (record.sample) this.status.textContent += ` ${message(error)}`;
      else desk.fail(error);
    }
  }

  private async compile(): Promise<void> {
    if (!this.fitted) return;
    const { machine, bench } = this.desk;
    const bytes = await bench.call("thermal_compile", machine.json, "thermal.toml", this.fitted.toml);
    save(`${machine.name}.ttherm`, Uint8Array.from(bytes), "application/octet-stream");
  }

  private describe(): void {
    const option = (name: string, list: string) => (typed(list).length > 0 ? ` ${name} ${typed(list).join(",")}` : "");
    const { name } = this.desk.machine;
    this.command.set(`trueaxis thermal fit ${word(this.record?.name ?? "record.csv")} --machine ${word(name)}${option("--hold-out", this.holdOut.value)}${option("--without", this.without.value)} -o thermal.toml`);
  }
}
