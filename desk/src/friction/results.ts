// The identified friction, and the circles simulated with it.

import { button, el, section } from "../core/dom";
import { save } from "../core/files";
import { significant } from "../core/number";
import { Sentence, showPlots, showPolars, showTables } from "../core/shown";
import type { Shown } from "../core/shown-types";
import type { Found } from "./documents";

export interface ResultEvents {
  copied(done: Promise<void>): void;
  merge(): void;
  simulate(): void;
}

export class Results {
  readonly root: HTMLElement;
  readonly closed: HTMLElement;
  private readonly sentence = new Sentence();
  private readonly figures = el("div", { class: "figures" });
  private readonly spikes = el("div", { class: "grid" });
  private readonly circles = el("div");
  private readonly settings = el("pre", { tabindex: 0, role: "group", "aria-label": "Settings found" });
  private readonly closedFigures = el("div", { class: "figures" });
  private readonly closedSpikes = el("div", { class: "grid" });
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
    this.root = el("div", {}, this.sentence.root, el("div", { class: "columns" }, curves, found));
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

  show({ shown, largest, settings }: Found): void {
    this.closed.hidden = true;
    this.root.hidden = false;
    this.sentence.set(`The largest spike falls ${largest.map(([axis, [before, after]]) => `from ${significant(before, 3)} to ${significant(after, 3)} µm in ${axis}`).join(", ")}.`);
    showTables(this.figures, shown);
    this.settings.textContent = settings;
    showPlots(this.spikes, shown.plots);
    showPolars(this.circles, shown.polars);
    if (shown.polars.length === 0) this.circles.append(el("p", {}, "The record holds no whole circle."));
  }

  showClosed(shown: Shown): void {
    this.closed.hidden = false;
    showTables(this.closedFigures, shown);
    showPlots(this.closedSpikes, shown.plots);
    showPolars(this.closedCircles, shown.polars);
  }
}
