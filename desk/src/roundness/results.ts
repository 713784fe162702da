// Tables and plots of evaluated readings or of a trace.

import type { Desk } from "../core/desk";
import { el, section } from "../core/dom";
import { clearest } from "../core/sentence";
import { Sentence, showPlots, tabled } from "../core/shown";
import type { Plot, Shown } from "../core/shown-types";
import { themed } from "./picture";

export class Results {
  readonly sentence = new Sentence();
  readonly tables = el("div", { class: "tables" });
  readonly root = el("div");
  private readonly orbit = el("div", { class: "drawn" });

  constructor(private readonly desk: Desk) {}

  /** Tables, and a section for the plots of each heading; a trace has no plots. */
  async show(shown: Shown): Promise<void> {
    const { tables, plots } = shown;
    this.sentence.set(clearest(shown));
    this.tables.replaceChildren(...tables.map(tabled));
    this.root.replaceChildren();
    this.root.hidden = plots.length === 0;
    const sections = new Map<string, Plot[]>();
    for (const plot of plots) sections.set(plot.section, [...(sections.get(plot.section) ?? []), plot]);
    for (const [heading, own] of sections) {
      const host = el("div", { class: own.length > 1 ? "pair" : "" });
      // The orbit over its motion is not a plot over one column of positions.
      this.root.append(section(heading, heading === "Spindle" ? el("figure", {}, this.orbit) : null, host));
      showPlots(host, own);
    }
    if (sections.has("Spindle")) this.orbit.innerHTML = themed(await this.desk.bench.call("roundness_orbit"));
  }

  clear(): void {
    this.root.hidden = true;
    this.sentence.set("");
    this.tables.replaceChildren();
  }
}
