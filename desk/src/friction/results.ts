// The identified friction, and the circles simulated with it.

import { button, el, section } from "../core/dom";
import { save } from "../core/files";
import { showTables } from "../core/shown";
import { showCircles, showSpikes, type Stage } from "./curves";
import type { CircleCurves, Closed, Found, SpikeCurves } from "./documents";

export interface ResultEvents {
  copied(done: Promise<void>): void;
  merge(): void;
  simulate(): void;
}

type Pair = readonly [string, string];

export class Results {
  readonly root: HTMLElement;
  readonly closed: HTMLElement;
  private readonly figures = el("div", { class: "figures" });
  private readonly spikes = el("div");
  private readonly circles = el("div");
  private readonly settings = el("pre", { tabindex: 0, role: "group", "aria-label": "Settings found" });
  private readonly closedFigures = el("div", { class: "figures" });
  private readonly closedSpikes = el("div");
  private readonly closedCircles = el("div");
  private readonly actions: HTMLButtonElement[];

  constructor(events: ResultEvents) {
    const { settings } = this;
    const merge = button("Put into the machine", () => events.merge());
    const simulate = button("Simulate with these figures", () => events.simulate(), { class: "primary" });
    const copy = button("Copy the settings", () => events.copied(navigator.clipboard.writeText(settings.textContent ?? "")));
    const keep = button("Save friction.toml", () => save("friction.toml", settings.textContent ?? ""));
    this.actions = [merge, simulate];
    const found = section("Figures", this.figures, el("h3", {}, "Settings for machine.toml"), settings, el("div", { class: "row" }, copy, keep, merge, simulate));
    const curves = section("Spikes at the reversals", this.spikes, el("h3", {}, "Radial deviation by friction, positive outward"), this.circles);
    this.root = el("div", { class: "columns" }, curves, found);
    const again = el("div", {}, this.closedSpikes, el("h3", {}, "Radial deviation by friction, positive outward"), this.closedCircles);
    this.closed = section("The circles again, simulated with the figures found", el("div", { class: "columns" }, again, this.closedFigures));
    this.clear();
  }

  enable(free: boolean): void {
    for (const action of this.actions) action.disabled = !free;
  }

  clear(): void {
    this.root.hidden = this.closed.hidden = true;
  }

  show(found: Found, axes: Pair): void {
    this.closed.hidden = true;
    this.root.hidden = false;
    showTables(this.figures, found.shown);
    this.settings.textContent = found.settings;
    const stages = <T extends SpikeCurves | CircleCurves>(of: T[]): Stage<T>[] => [
      { name: "before, recorded", colour: "before", of, value: (curves) => curves.before_um },
      { name: "predicted by the model", colour: "measured", dash: [2, 3], of, value: (curves) => curves.predicted_um },
      { name: "after, expected", colour: "after", dash: [7, 3], of, value: (curves) => curves.after_um },
    ];
    showSpikes(this.spikes, stages(found.spikes));
    showCircles(this.circles, axes, stages(found.circles));
  }

  showClosed(closed: Closed, axes: Pair): void {
    this.closed.hidden = false;
    this.closedFigures.replaceChildren();
    if (closed.shown) showTables(this.closedFigures, closed.shown);
    const stages = <T extends SpikeCurves | CircleCurves>(before: T[], after: T[]): Stage<T>[] => [
      { name: "before, simulated", colour: "before", of: before, value: (curves) => curves.before_um },
      { name: "after, simulated", colour: "after", dash: [7, 3], of: after, value: (curves) => curves.before_um },
    ];
    showSpikes(this.closedSpikes, stages(closed.before.spikes, closed.after.spikes));
    showCircles(this.closedCircles, axes, stages(closed.before.circles, closed.after.circles));
  }
}
