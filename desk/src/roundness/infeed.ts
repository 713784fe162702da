// A crankpin ground with and without infeed correction.

import type { Desk } from "../core/desk";
import { button, choice, commandLine, el, group, numberField, section, type Field } from "../core/dom";
import { word } from "../core/shell";
import { showPlots, showTables } from "../core/shown";
import type { Plot, Shown } from "../core/shown-types";

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
  private readonly progress = el("progress", { max: 1, value: 0, hidden: true, "aria-label": "Grinding" });
  private readonly figures = el("div", { class: "tables" });
  private readonly start: HTMLButtonElement;
  private readonly command = commandLine("The same on the command line:");
  private readonly plots = el("div", { class: "pair", hidden: true });
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
      const plots = async () => JSON.parse(await runs.call("grinding_plots")) as Plot[];
      const draw = showPlots(this.plots, await plots());
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
        draw(await plots());
      }
      const shown = JSON.parse(await runs.call("grinding_finish")) as Shown;
      showTables(this.figures, shown);
      this.stopped(shown.result);
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
}
