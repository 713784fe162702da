// A crankpin ground with and without infeed correction.

import type { Desk } from "../core/desk";
import { button, choice, commandLine, el, group, numberField, section, table, type Field } from "../core/dom";
import { cell, fixed } from "../core/number";
import { Plot } from "../core/plot";
import { word } from "../core/shell";
import type { Ground, RunFigures } from "./documents";

/** Request to `firmware-sim grind`. */
export interface GrindRequest {
  revolutions: number;
  rate_hz: number;
  speed_rpm: number;
  gain?: number;
  feed_um: number;
  seed: number;
}

const USUAL: GrindRequest = { revolutions: 40, rate_hz: 10_000, speed_rpm: 30, feed_um: 0.1, seed: 1 };
type Of = "sample" | "desk";

export class Infeed {
  readonly root: HTMLElement;
  private readonly fields: Record<keyof GrindRequest, Field>;
  private readonly of;
  private readonly roundness: Plot;
  private readonly imprint: Plot;
  private readonly progress = el("progress", { max: 1, value: 0, hidden: true, "aria-label": "Grinding" });
  private readonly figures = el("div", { class: "tables" });
  private readonly start: HTMLButtonElement;
  private readonly command = commandLine("The same on the command line:");
  private readonly plots: HTMLElement;
  private run = 0;
  /** Command line of the figures shown, until a setting is changed. */
  private ground: string | undefined;

  constructor(private readonly desk: Desk) {
    const say = () => this.say();
    const field = (label: string, value: number, rest: object) => numberField({ label, value, ...rest }, say);
    this.fields = {
      revolutions: field("Revolutions", USUAL.revolutions, { min: 8, max: 10_000, step: 1 }),
      speed_rpm: field("Spindle speed", USUAL.speed_rpm, { min: 0.1, unit: "rpm" }),
      rate_hz: field("Servo rate", USUAL.rate_hz, { min: 100, max: 100_000, unit: "Hz" }),
      feed_um: field("Feed that remains", USUAL.feed_um, { min: 0, max: 5, unit: "µm per revolution" }),
      gain: field("Gain of the correction", 0.25, { min: 0 }),
      seed: field("Seed", USUAL.seed, { min: 0, step: 1 }),
    };
    this.of = choice<Of>("Machine", [["sample", "sample grinder"], ["desk", "the desk's machine"]], "sample", say);
    this.start = button("Grind", () => void this.grind(), { class: "primary" });
    const [one, other] = [el("div"), el("div")];
    const series = [
      { name: "without correction", colour: "before" as const, dash: [7, 3] },
      { name: "with correction", colour: "after" as const },
    ];
    const options = { x: "revolution", series, sync: "ground", height: 240 };
    this.roundness = new Plot(one, { ...options, title: "Roundness of the ground pin", y: "peak to valley / µm" });
    this.imprint = new Plot(other, { ...options, title: "Imprint of the spindle in the corrected band", y: "root mean square / µm" });
    this.plots = el("div", { class: "pair", hidden: true }, one, other);
    this.root = section(
      "Infeed correction",
      el("p", {}, "A crankpin is ground twice from the same seed: the gauge of three probes measures while the servo step runs, and in the second run its infeed corrects the error measured in earlier revolutions."),
      group("Grinding", this.of.root, ...Object.values(this.fields).map((of) => of.root), this.start, this.progress),
      this.plots,
      this.figures,
      this.command.root,
    );
    this.say();
  }

  get value(): { machine: Of; request: GrindRequest } {
    const entries = Object.entries(this.fields).map(([key, field]) => [key, field.value]);
    return { machine: this.of.value, request: Object.fromEntries(entries) as GrindRequest };
  }

  set value({ machine, request }: { machine: Of; request: GrindRequest }) {
    this.of.value = machine;
    for (const [key, field] of Object.entries(this.fields)) field.value = request[key as keyof GrindRequest] ?? field.value;
    this.say();
  }

  private say(): void {
    const { machine, request } = this.value;
    const options = Object.entries(request).flatMap(([key, value]) => [`--${key.replaceAll("_", "-")}`, value]);
    const name = machine === "sample" ? "grinder" : this.desk.machine.name;
    const said = ["firmware-sim grind --machine", word(name), ...options, "--json"].join(" ");
    this.command.set(said);
    if (this.ground !== undefined && this.ground !== said) this.figures.replaceChildren(el("p", { class: "said" }, "The plots show the previous run; grind again for these settings."));
  }

  private async grind(): Promise<void> {
    this.run += 1;
    if (!this.progress.hidden) {
      this.stopped("Grinding was stopped.");
      return;
    }
    const mine = this.run;
    this.desk.clear();
    this.start.textContent = "Stop";
    this.progress.hidden = false;
    this.progress.value = 0;
    const { machine, request } = this.value;
    try {
      const { runs } = this.desk;
      const files = machine === "sample" ? await runs.call("grinding_machine") : this.desk.machine.json;
      await runs.call("grinding_open", files, JSON.stringify(request));
      this.ground = this.command.text();
      this.figures.replaceChildren();
      this.plots.hidden = false;
      let cycles = 2000;
      let share = 0;
      while (share < 1) {
        const begun = performance.now();
        share = await runs.call("grinding_advance", cycles);
        const took = performance.now() - begun;
        if (mine !== this.run) return;
        this.progress.value = share;
        if (took < 60) cycles *= 2;
        else if (took > 250) cycles = Math.max(500, cycles >> 1);
        await this.plot();
      }
      const found = JSON.parse(await runs.call("grinding_finish")) as Ground;
      this.show(found);
      this.stopped(`Ground: ${fixed(100 * found.imprint_ratio, 1)} % of the imprint remains.`);
    } catch (error) {
      if (mine === this.run) this.stopped("");
      this.desk.fail(error);
    }
  }

  private stopped(said: string): void {
    this.progress.hidden = true;
    this.start.textContent = "Grind";
    this.desk.note(said);
  }

  private async plot(): Promise<void> {
    const curve = (corrected: boolean, roundness: boolean) => this.desk.runs.call("grinding_curve", corrected, roundness);
    for (const [plot, roundness] of [[this.roundness, true], [this.imprint, false]] as const) {
      const [before, after] = await Promise.all([curve(false, roundness), curve(true, roundness)]);
      const turns = Array.from(before, (_, i) => i + 1);
      plot.set([turns, before, turns.map((_, i) => after[i] ?? null)]);
    }
  }

  private show(found: Ground): void {
    const row = (name: string, of: RunFigures) => [
      name,
      cell(of.roundness_um),
      cell(of.imprint_um, 4),
      ...[of.evaluated, of.skipped, of.discarded, of.limited_cycles].map((count) => ({ text: String(count), value: count })),
    ];
    const header = ["run", "roundness / µm", "imprint / µm", "revolutions evaluated", "skipped", "discarded", "cycles limited"];
    const caption = `Mean of the last ${found.averaged_revolutions} revolutions; harmonics ${found.harmonics.join(" to ")} are corrected`;
    const share = el("strong", { "data-value": String(found.imprint_ratio) }, `${fixed(100 * found.imprint_ratio, 1)} %`);
    const limits = found.limits_exceeded === 0 ? "No correction exceeded a limit" : `In ${found.limits_exceeded} ${found.limits_exceeded === 1 ? "cycle" : "cycles"} a correction exceeded a limit`;
    this.figures.replaceChildren(
      table(caption, header, [row("without correction", found.uncorrected), row("with correction", found.corrected)]),
      el("p", {}, share, ` of the imprint remains at a gain of ${found.gain}. ${limits}; ${found.cycles} servo cycles a run.`),
    );
  }
}
