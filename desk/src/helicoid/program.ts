// The program: saved, copied, run in the scope.

import type { Desk } from "../core/desk";
import { button, commandLine, el } from "../core/dom";
import { save } from "../core/files";
import type { Files } from "../core/machine";
import type { Fit } from "./documents";
import { command, request, type Inputs } from "./request";

/** The sample whose chain is that of the displacements. */
const SAMPLE = "mill-turn";
const NAME = "helicoid";

export class Program {
  readonly root: HTMLElement;
  readonly machine: HTMLElement;
  private readonly line = commandLine("The same on the command line");
  private readonly said = el("span", { role: "status", class: "said" });
  private readonly fits = el("p", { role: "status" });
  private readonly text = el("pre", { class: "rows", tabindex: 0, role: "group", "aria-label": "Text of the program" });
  private readonly details: HTMLDetailsElement;

  constructor(
    private readonly desk: Desk,
    private readonly inputs: () => Inputs,
    private readonly fit: () => Fit | undefined,
  ) {
    const act = (work: () => Promise<void>) => () => void work().catch((error: unknown) => desk.fail(error));
    const store = async (name: string, call: "helicoid_gcode" | "helicoid_csv" | "helicoid_document", type: string) =>
      save(name, await desk.bench.call(call, request(this.inputs())), type);
    const change = button("Take a machine that fits", act(() => this.adapt()));
    this.machine = el("div", { class: "row" }, this.fits, change);
    this.details = el("details", { ontoggle: act(() => this.fill()) }, el("summary", {}, "Text of the program"), this.text);
    this.root = el("div", {},
      el("div", { class: "row" },
        button("Run in the scope", act(() => this.run()), { class: "primary" }),
        button("Save G-code", act(() => store(`${NAME}.ngc`, "helicoid_gcode", "text/plain;charset=utf-8"))),
        button("Copy G-code", act(() => this.copy())),
        button("Save CSV", act(() => store(`${NAME}.csv`, "helicoid_csv", "text/csv"))),
        button("Save JSON", act(() => store(`${NAME}.json`, "helicoid_document", "application/json"))),
        this.said),
      this.line.root,
      this.details);
  }

  /** Sets other inputs, or another machine. */
  set(): void {
    this.line.set(command(this.inputs()));
    this.said.textContent = "";
    const fit = this.fit();
    if (fit)
      this.fits.textContent = fit.fits
        ? `The machine of the desk, ${fit.machine}, fits: the displacements are its axes' positions.`
        : `The machine of the desk, ${fit.machine}, does not fit: ${fit.reasons.join("; ")}.`;
    (this.machine.lastElementChild as HTMLElement).hidden = fit?.fits ?? true;
    void this.fill().catch((error: unknown) => this.desk.fail(error));
  }

  private async fill(): Promise<void> {
    if (this.details.open) this.text.textContent = await this.desk.bench.call("helicoid_gcode", request(this.inputs()));
  }

  private async copy(): Promise<void> {
    const text = await this.desk.bench.call("helicoid_gcode", request(this.inputs()));
    try {
      await navigator.clipboard.writeText(text);
      this.said.textContent = "copied";
    } catch {
      this.said.textContent = "not permitted here: save it instead";
    }
  }

  /** Makes the sample machine, adapted to the inputs, the desk's machine. */
  private async adapt(): Promise<void> {
    const sample = await this.desk.bench.call("machine_sample", SAMPLE);
    const files = JSON.parse(await this.desk.bench.call("helicoid_machine", request(this.inputs()), sample)) as Files;
    this.desk.machine.set(SAMPLE, files);
    const { form } = this.inputs();
    this.desk.note(`The machine of the desk is now the sample ${SAMPLE}, ${form}, with the pivot length and directions of the helicoid.`);
  }

  private async run(): Promise<void> {
    const text = await this.desk.bench.call("helicoid_gcode", request(this.inputs()));
    if (!this.fit()?.fits) await this.adapt();
    await this.desk.openProgram({ name: `${NAME}.ngc`, text });
  }
}
