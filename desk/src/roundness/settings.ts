// Settings of the evaluation: probes, arm, filter, limit.

import { el, group, numberField, tick, unique } from "../core/dom";
import { word } from "../core/shell";
import { probeOptions, type Request } from "./documents";
import { ProbeControls } from "./probes";

/** Cut-offs of the filter in undulations per revolution, from none to the finest. */
const FILTERS = [undefined, 15, 50, 150, 500] as const;

export class Settings {
  readonly root: HTMLElement;
  readonly probes: ProbeControls;
  private arm: [number, number, number] = [45, 300, 27.5];
  private readonly follows;
  private readonly lengths;
  private readonly filter;
  private readonly limit;

  constructor(
    private request: Request,
    private readonly changed: () => void,
  ) {
    this.probes = new ProbeControls("Probes of these readings", request.probes, () => {
      this.request = { ...this.request, probes: this.probes.value };
      changed();
    });
    const length = (label: string, place: 0 | 1 | 2) =>
      numberField({ label, unit: "mm", value: this.arm[place], min: 0 }, (value) => {
        this.arm[place] = value;
        this.rearm();
      });
    this.lengths = [length("Crank throw R", 0), length("Wheel radius RS", 1), length("Pin radius RW", 2)];
    this.follows = tick("Arm follows the pin", request.arm !== undefined, () => this.rearm());
    this.filter = filterSlider((upr) => {
      const { upr: _, ...rest } = this.request;
      this.request = upr === undefined ? rest : { ...rest, upr };
      changed();
    });
    this.limit = numberField({ label: "Noise gain limit", value: request.noise_gain_limit, min: 1e-9 }, (noise_gain_limit) => {
      this.request = { ...this.request, noise_gain_limit };
      changed();
    });
    this.root = el(
      "div",
      { class: "settings" },
      this.probes.root,
      group("Arm", this.follows.root, ...this.lengths.map((field) => field.root)),
      group("Evaluation", this.filter.root, this.limit.root),
    );
    this.value = request;
  }

  get value(): Request {
    return this.request;
  }

  set value(request: Request) {
    this.request = request;
    this.probes.value = request.probes;
    if (request.arm) this.arm = [...request.arm];
    this.follows.input.checked = request.arm !== undefined;
    this.lengths.forEach((field, i) => {
      field.value = this.arm[i]!;
      field.input.disabled = request.arm === undefined;
    });
    this.filter.set(request.upr);
    this.limit.value = request.noise_gain_limit;
  }

  /** The command that gives the same result. */
  command(file: string): string {
    const { probes, arm, upr, noise_gain_limit } = this.request;
    const options = [...probeOptions(probes), ...(arm ? ["--arm", arm.join(",")] : []), ...(upr ? ["--upr", upr] : [])];
    return ["trueaxis roundness", word(file), ...options, "--noise-gain-limit", noise_gain_limit, "--json"].join(" ");
  }

  private rearm(): void {
    const { arm: _, ...rest } = this.request;
    this.value = this.follows.input.checked ? { ...rest, arm: [...this.arm] } : rest;
    this.changed();
  }
}

/** A slider over the cut-offs, which are not evenly spaced. */
function filterSlider(take: (upr: number | undefined) => void): { root: HTMLElement; set(upr: number | undefined): void } {
  const id = unique("filter");
  const input = el("input", { id, type: "range", min: 0, max: FILTERS.length - 1, step: 1, value: 0 });
  const said = el("output", { for: id });
  const say = () => {
    const upr = FILTERS[input.valueAsNumber];
    said.textContent = upr === undefined ? "none" : `${upr} UPR`;
    input.setAttribute("aria-valuetext", said.textContent);
    return upr;
  };
  input.addEventListener("input", () => take(say()));
  const root = el("div", { class: "field filter" }, el("label", { for: id }, "Gaussian filter, undulations per revolution"), el("div", {}, input, said));
  const set = (upr: number | undefined) => {
    input.value = String(Math.max(0, FILTERS.indexOf(upr as (typeof FILTERS)[number])));
    say();
  };
  set(undefined);
  return { root, set };
}
