// Run, pause, steps, and the progress of a run.

import { button, choice, el, numberField } from "../core/dom";
import { fixed } from "../core/number";
import type { Description, Progress } from "./documents";
import type { Pace } from "./runner";

export interface BarHost {
  run(pace: Pace): void;
  pause(): void;
  step(cycles: number): void;
  restart(): void;
  pace(pace: Pace): void;
}

export class Bar {
  readonly root: HTMLElement;
  private readonly paced;
  private readonly buttons: Record<"run" | "pause" | "step" | "restart" | "end", HTMLButtonElement>;
  private readonly meter: HTMLProgressElement;
  private readonly said: HTMLElement;
  private readonly stale: HTMLElement;

  constructor(host: BarHost) {
    const pace = (this.paced = choice<Pace>("Pace", [["fast", "unpaced"], ["real", "real time"], ["slow", "a tenth of it"]], "fast", (value) => host.pace(value)));
    const cycles = numberField({ label: "Cycles", value: 1000, min: 1, max: 1e6, step: 1 }, () => {});
    this.buttons = {
      run: button("Run", () => host.run(pace.value), { class: "primary" }),
      pause: button("Pause", () => host.pause()),
      step: button("Step on", () => host.step(cycles.value)),
      end: button("To the end", () => {
        pace.value = "fast";
        host.run("fast");
      }),
      restart: button("Restart", () => host.restart()),
    };
    const { run, pause, step, end, restart } = this.buttons;
    this.meter = el("progress", { max: 1, value: 0, "aria-label": "Progress of the run" });
    this.said = el("output", { class: "readout" });
    this.stale = el("span", { class: "warning", role: "status" });
    this.root = el(
      "div",
      { class: "bar" },
      el("div", { class: "row inline" }, run, pause, end, restart, step, cycles.root, pace.root),
      el("div", { class: "meter" }, this.meter, this.said, this.stale),
    );
  }

  set(progress: Progress, description: Description, rate: number, going: boolean): void {
    const { run, pause, step, end, restart } = this.buttons;
    run.disabled = end.disabled = going || progress.done;
    step.disabled = progress.done;
    pause.disabled = !going;
    restart.disabled = progress.cycle === 0;
    this.meter.value = progress.cycles > 0 ? progress.cycle / progress.cycles : 0;
    const whole = (value: number) => value.toLocaleString("en");
    const length = fixed(progress.cycles * description.period_s, 2);
    const speed = rate > 0 ? `   ${fixed(rate / 1e6, 3)} million cycles a second, ${description.kinds.length} machines each` : "";
    const state = progress.done ? "done" : going ? "running" : progress.cycle > 0 ? "paused" : "ready";
    this.said.textContent = `${state}: ${whole(progress.cycle)} of ${whole(progress.cycles)} cycles, ${fixed(progress.time_s, 4)} of ${length} s${speed}`;
    this.root.dataset.state = state;
  }

  get pace(): Pace {
    return this.paced.value;
  }

  set pace(pace: Pace) {
    this.paced.value = pace;
  }

  /** Shows the changes that Restart would apply. */
  changed(what: string): void {
    this.stale.textContent = what;
    this.buttons.restart.classList.toggle("primary", what !== "");
  }
}
