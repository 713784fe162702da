// Tip error along a line of the flank, before and after correction by the machine's tables.

import { message, type Desk } from "../core/desk";
import { el, table, type Cell } from "../core/dom";
import { cell } from "../core/number";
import { Plot } from "../core/plot";
import type { Flanked } from "./documents";
import { POINTS, type Line } from "./curves";
import { request, type Inputs } from "./request";

export class Flank {
  readonly root: HTMLElement;
  private readonly said = el("p", { role: "status" });
  private readonly figures = el("div");
  private readonly host = el("div");
  private plot: Plot | undefined;
  private line: Line | undefined;

  constructor(private readonly desk: Desk) {
    this.root = el("div", {}, this.said, this.figures, this.host);
  }

  async set(inputs: Inputs, line: Line, held: number): Promise<void> {
    let found: Flanked;
    try {
      found = JSON.parse(await this.desk.bench.call("helicoid_flank", request(inputs), this.desk.machine.json, line, held, POINTS)) as Flanked;
    } catch (error) {
      this.said.textContent = `This machine cannot move the tool there. ${message(error)}`;
      this.figures.hidden = this.host.hidden = true;
      return;
    }
    this.figures.hidden = this.host.hidden = false;
    const { fit, before, after, out_of_travel } = found;
    const by = fit.fits
      ? `On ${fit.machine}, at the displacements above.`
      : `On ${fit.machine}, ${fit.chain}, at different positions for the same poses of the tool: the displacements above are another machine's (${fit.reasons.join("; ")}).`;
    const beyond = out_of_travel.length > 0 ? ` Beyond the declared travel on the way: ${out_of_travel.join(", ")}.` : "";
    this.said.textContent = `${by} Exact geometry; after: with the correction that the servo step settles to.${beyond}`;
    const names = ["Tip / µm", "Along the normal / µm", "Direction of the tool / µrad"];
    this.figures.replaceChildren(
      table("Largest errors along the line", ["", "Before", "After"], names.map((name, i): Cell[] => [name, cell(before.largest[i], 4), cell(after.largest[i], 4)])),
    );
    this.build(line).set([found.parameter_rad, before.tip_um, after.tip_um, before.normal_um, after.normal_um]);
  }

  private build(line: Line): Plot {
    if (this.plot && this.line === line) return this.plot;
    this.line = line;
    this.host.replaceChildren();
    this.plot = new Plot(this.host, {
      title: `Error of the tip along the flank, over ${line === "theta" ? "θ" : "u"}`,
      x: line === "theta" ? "θ / rad" : "u / rad",
      y: "error / µm",
      sync: "helicoid",
      height: 190,
      series: [
        { name: "tip, before", colour: "before", width: 1.8, unit: "µm" },
        { name: "tip, after", colour: "after", width: 1.8, unit: "µm" },
        { name: "along the normal, before", colour: "before", dash: [6, 4], unit: "µm" },
        { name: "along the normal, after", colour: "after", dash: [6, 4], unit: "µm" },
      ],
    });
    return this.plot;
  }
}
