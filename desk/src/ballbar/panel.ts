// A recorded circle: figures after ISO 230-4, causes of the deviation, and the corrections written to the machine.

import sample from "../../../records/ballbar.csv";
import { IntoMachine, type Becomes } from "../core/becomes";
import { message, type Desk } from "../core/desk";
import { choice, commandLine, el, group, numberField, optionalField, section, tick } from "../core/dom";
import { onDrop, picker, plainName, type Given } from "../core/files";
import { FIRST_MACHINE, Samples } from "../core/sample";
import { word } from "../core/shell";
import type { Axes, Evaluated, Request } from "./documents";
import { Results } from "./results";

export interface ViewState {
  request: Request;
  compensated: boolean;
  /** Whether the record is the sample, which a file need not contain. */
  sample?: boolean;
}

const PLANES: readonly Axes[] = ["X,Y", "Z,X", "Y,Z", "Y,X", "X,Z", "Z,Y"];
const LETTERS = ["X", "Y", "Z"] as const;

export class Ballbar {
  private request: Request = { radius_mm: 100, axes: "X,Y", pitches_mm: [null, null, null] };
  private compensated = false;
  private record: { name: string; bytes: Uint8Array; sample: boolean } | undefined;
  private latest = 0;
  private readonly radius;
  private readonly plane;
  private readonly pitches: HTMLInputElement[];
  private readonly corrected;
  private readonly status = el("span", { role: "status" });
  private readonly command = commandLine("The same on the command line:");
  private readonly samples = new Samples([["Try a sample", () => this.trySample()]]);
  private readonly results = new Results();
  private readonly into: IntoMachine;

  constructor(
    root: HTMLElement,
    private readonly desk: Desk,
  ) {
    const again = () => void this.evaluate();
    this.radius = numberField({ label: "Nominal radius", unit: "mm", value: this.request.radius_mm }, (mm) => {
      this.request.radius_mm = mm;
      again();
    });
    this.plane = choice<Axes>("Axes of the plane, in its sense", PLANES.map((axes) => [axes, axes] as const), this.request.axes, (axes) => {
      this.request.axes = axes;
      again();
    });
    const pitches = LETTERS.map((letter, i) => {
      return optionalField(`Pitch of ${letter}`, "mm", "searched", (mm) => {
        this.request.pitches_mm[i] = mm;
        again();
      });
    });
    this.pitches = pitches.map(({ input }) => input);
    this.corrected = tick("The machine's tables corrected it during the circles: add the errors found to them", false, (compensated) => {
      this.compensated = compensated;
      void this.settings();
    });
    this.into = new IntoMachine(desk, "Errors found by the circular test", this.corrected.root);
    const files = picker("Open a record", { accept: ".csv,.txt,.bin" }, (given) => this.take(given), desk.fail);
    const form = el("small", {}, "or drop one: angle_deg,deviation_um,direction of a bar; x_cmd_mm,x_mm,y_cmd_mm,y_mm; lines of LinuxCNC's halsampler; telemetry");
    root.append(
      section(
        "Record",
        el("div", { class: "source" }, group("Recorded circles about one centre", files, form), group("Data of the circles", this.radius.root, this.plane.root), group("Pitch of periodic errors", ...pitches.map((field) => field.root))),
        this.samples.root,
        el("div", { class: "row" }, this.status),
        this.command.root,
      ),
      this.results.root,
      this.into.root,
    );
    this.into.root.hidden = true;
    onDrop(root, (given) => this.take(given), desk.fail);
    desk.machine.subscribe(() => {
      this.describe();
      void this.settings();
    });
    desk.bench.onRestart(() => this.forget("The record was lost with the computation: drop it again."));
    this.describe();
    if (desk.machine.name === FIRST_MACHINE) this.trySample();
  }

  get state(): ViewState {
    return { request: structuredClone(this.request), compensated: this.compensated, ...(this.record?.sample ? { sample: true } : {}) };
  }

  /** The state contains no record but the sample: the user must drop any other again. */
  open({ request, compensated, sample }: ViewState): void {
    this.request = structuredClone(request);
    this.compensated = this.corrected.input.checked = compensated;
    this.radius.value = request.radius_mm;
    this.plane.value = request.axes;
    this.pitches.forEach((input, i) => (input.value = String(request.pitches_mm[i] ?? "")));
    this.describe();
    if (sample) this.trySample();
    else this.forget("The record was a file: drop it again.");
  }

  private take([file]: Given[]): void {
    if (!file) return;
    this.record = { name: plainName(file.path), bytes: file.bytes, sample: false };
    void this.evaluate();
  }

  private trySample(): void {
    this.record = { name: "ballbar.csv", bytes: new TextEncoder().encode(sample), sample: true };
    void this.evaluate();
  }

  private forget(why: string): void {
    this.latest += 1;
    this.record = undefined;
    this.samples.shown = false;
    this.status.textContent = why;
    this.results.clear();
    this.into.root.hidden = true;
  }

  private async evaluate(): Promise<void> {
    this.describe();
    const { record, request } = this;
    if (!record) return;
    const turn = ++this.latest;
    this.samples.shown = record.sample;
    this.status.textContent = `Evaluating ${record.name} …`;
    try {
      const said = await this.desk.bench.call("ballbar_evaluate", record.name, record.bytes, JSON.stringify(request));
      if (turn !== this.latest) return;
      const found = JSON.parse(said) as Evaluated;
      this.desk.clear();
      this.status.textContent = [`${record.name}: ${found.shown.summary.join(", ")}.`, ...found.notes].join(" ");
      this.results.show(found);
      this.into.begin();
      this.into.root.hidden = false;
      await this.settings();
    } catch (error) {
      if (turn !== this.latest) return;
      this.status.textContent = `${record.name} could not be evaluated.`;
      this.results.clear();
      this.into.root.hidden = true;
      this.desk.fail(error);
    }
  }

  /** Computes the changes to the page's machine. */
  private async settings(): Promise<void> {
    if (this.into.root.hidden) return;
    const turn = this.latest;
    try {
      const said = await this.desk.bench.call("ballbar_settings", this.desk.machine.json, this.compensated);
      if (turn === this.latest) this.into.show(JSON.parse(said) as Becomes);
    } catch (error) {
      this.into.show(undefined, message(error));
    }
    this.describe();
  }

  private describe(): void {
    const { radius_mm, axes, pitches_mm } = this.request;
    const machine = word(this.desk.machine.name);
    const pitch = LETTERS.flatMap((letter, i) => (pitches_mm[i] === null ? [] : [`--pitch-${letter.toLowerCase()}-mm ${pitches_mm[i]}`]));
    const parts = [`trueaxis ballbar ${word(this.record?.name ?? "record.csv")}`, `--radius-mm ${radius_mm}`, `--axes ${axes}`, ...pitch, `--machine ${machine}`, ...(this.compensated ? ["--compensated"] : []), `-o ${machine}`];
    this.command.set(parts.join(" "));
  }
}
