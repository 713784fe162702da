// Form fields: gear, machine, grid, program.

import { choice, el, group, numberField, slider, type Field } from "../core/dom";
import type { Inputs, Span } from "./request";

type Names<T> = { [K in keyof Inputs]: Inputs[K] extends T ? K : never }[keyof Inputs];

/** The form of these inputs; a change of a field changes them and is reported. */
export function form(inputs: Inputs, changed: () => void): HTMLElement {
  const number = (name: Names<number>, label: string, unit?: string): HTMLElement =>
    numberField({ label, value: inputs[name], ...(unit ? { unit } : {}) }, (value) => set(name, value)).root;
  const slide = (name: Names<number>, label: string, unit: string, min: number, max: number, step: number): HTMLElement => {
    const { root, input } = slider({ label, value: inputs[name], min, max, step, ...(unit ? { unit } : {}) }, (value) => set(name, value));
    // The field accepts any number; the module refuses bad ones, with the command line's message.
    input.step = "any";
    input.removeAttribute("min");
    input.removeAttribute("max");
    return root;
  };
  const set = <K extends keyof Inputs>(name: K, value: Inputs[K]) => {
    inputs[name] = value;
    changed();
  };
  const pick = <K extends Names<string | number>>(name: K, label: string, options: ReadonlyArray<readonly [string, string]>, take = (text: string) => text as Inputs[K]): HTMLElement =>
    choice(label, options, String(inputs[name]), (text) => {
      set(name, take(text));
      reveal();
    }).root;
  const senses = [["1", "+1"], ["-1", "−1"]] as const;
  const whole = (text: string) => Number(text) as never;

  const gear = el("div", { class: "pair" },
    slide("module_mm", "Normal module", "mm", 0.5, 20, 0.1),
    slide("teeth", "Teeth", "", 6, 150, 1),
    slide("pressure_angle_deg", "Normal pressure angle", "degrees", 5, 35, 0.5),
    slide("helix_angle_deg", "Helix angle", "degrees", -60, 60, 0.5));
  const base = el("div", { class: "pair" },
    slide("base_radius_mm", "Base radius", "mm", 1, 500, 0.5),
    slide("lead_parameter_mm_per_rad", "Lead parameter", "mm/rad", -1000, 1000, 1));
  const length = el("div", { class: "pair" }, slide("pivot_mm", "Pivot length", "mm", 0, 600, 1));
  const finder = el("div", { class: "pair" },
    number("edge_finder_mm", "Edge finder, travel", "mm"),
    number("edge_finder_radius_mm", "Edge finder, ball radius", "mm"));
  const reveal = () => {
    [gear.hidden, base.hidden] = [inputs.source !== "gear", inputs.source !== "base"];
    [length.hidden, finder.hidden] = [inputs.pivot !== "length", inputs.pivot !== "finder"];
  };
  reveal();

  const offset = (["X", "Y", "Z"] as const).map((axis, i) =>
    numberField({ label: `Work offset ${axis}`, unit: "mm", value: inputs.work_offset_mm[i]! }, (value) => {
      inputs.work_offset_mm[i] = value;
      changed();
    }).root);

  return el("div", { class: "inputs" },
    group("Flank",
      pick("source", "Given by", [["gear", "gear"], ["base", "base circle and lead"]]),
      pick("flank", "Side, from +z, tip up", [["right", "right, u ≥ 0"], ["left", "left, u ≤ 0"]]),
      gear, base),
    group("Machine",
      pick("form", "Spindle at A = 0", [["vertical", "vertical, along +z"], ["horizontal", "horizontal, along +y"]]),
      pick("pivot", "Pivot length from", [["length", "a length"], ["finder", "an edge finder"]]),
      length, finder,
      triple(
        pick("direction_a", "Direction of A", senses, whole),
        pick("direction_c", "Direction of C", senses, whole),
        pick("branch", "Branch", [["1", "1"], ["2", "2"]], whole)),
      triple(...offset)),
    group("Grid", span("u", inputs.u, changed), span("θ", inputs.theta, changed)),
    group("Program",
      triple(
        pick("passes", "Passes along", [["theta", "θ"], ["u", "u"]]),
        number("feed_mm_per_min", "Feed", "mm/min"),
        number("clearance_mm", "Clearance", "mm"))));
}

function triple(...fields: HTMLElement[]): HTMLElement {
  return el("div", { class: "triple" }, ...fields);
}

/** Start, stop and count of a parameter. */
function span(name: string, of: Span, changed: () => void): HTMLElement {
  const part = (key: keyof Span, label: string, unit?: string): Field =>
    numberField({ label: `${name} ${label}`, value: of[key], ...(unit ? { unit } : {}) }, (value) => {
      of[key] = value;
      changed();
    });
  return triple(part("start", "from", "rad").root, part("stop", "to", "rad").root, part("count", "values").root);
}
