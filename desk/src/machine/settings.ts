// Squareness, backlash and temperature by sliders; the other settings of the selected axis.

import { choice, el, group, numberField, section, slider, type Child, type Field } from "../core/dom";
import { display } from "./display";
import { length, micro, type Axis } from "./document";
import type { Editor } from "./editor";
import type { Tables } from "./tables";

const SQUARENESS = [
  ["A0Z", "Z to Y"],
  ["B0Z", "Z to X"],
  ["C0Y", "Y to X"],
] as const;

/** A control and the value that it shows. */
type Bound = [Field, () => number | undefined];

export class Settings {
  readonly root: HTMLElement;
  /** Controls of the selected axis. */
  readonly own = el("div");
  private readonly sliders = el("div", { class: "settings" });
  private bound: Bound[] = [];
  private ownBound: Bound[] = [];
  private built = "";
  private builtOwn = "";
  private readonly model: { root: HTMLElement; choice: { value: string } };

  constructor(
    private readonly editor: Editor,
    private readonly tables: Tables,
  ) {
    this.root = section("Settings of the machine", this.sliders);
    const models = choice<string>("Of the machine", [["nine", "nine-term"], ["volumetric", "volumetric"]], "nine", (value) => this.set("compensation.model", value, ""));
    this.model = { root: group("Error model", models.root), choice: models };
    editor.subscribe(() => this.render());
    tables.onChoice(() => this.render());
  }

  render(): void {
    const axes = this.editor.shown?.axes ?? [];
    const letters = axes.map(({ axis }) => axis).join("");
    if (letters !== this.built) {
      this.built = letters;
      this.bound = [];
      this.sliders.replaceChildren(this.squareness(), this.backlash(axes), el("div", { class: "pair" }, this.temperature(), this.model.root));
    }
    this.model.choice.value = this.editor.shown?.check.summary.model ?? "nine";
    const axis = this.tables.axis;
    const key = `${axis?.axis} ${axis?.interpolation}`;
    if (axis && key !== this.builtOwn) {
      this.builtOwn = key;
      this.ownBound = [];
      this.own.replaceChildren(this.ofAxis(axis));
    }
    for (const [field, value] of [...this.bound, ...this.ownBound]) {
      const now = value();
      // A control being moved is ahead of the machine.
      if (now === undefined || (!this.editor.settled && field.root.contains(document.activeElement))) continue;
      const shown = Number(now.toPrecision(12));
      if (field.value !== shown) field.value = shown;
    }
  }

  private set(key: string, value: number | string, unit: string): void {
    void this.editor.apply({ change: "key", key, value }, `${key} = ${value}${unit ? ` ${unit}` : ""}`, `key ${key}`);
  }

  private axis(letter: string): Axis | undefined {
    return this.editor.shown?.axes.find(({ axis }) => axis === letter);
  }

  private squareness(): HTMLElement {
    const fields = SQUARENESS.map(([name, axes], index) => {
      const options = { label: `${name}, ${axes}`, unit: "µrad", value: 0, min: -300, max: 300, step: 0.5 };
      const field = slider(options, (value) => this.set(`location.${name}_urad`, value, "µrad"));
      this.bound.push([field, () => this.editor.shown?.check.summary.squareness_urad[index]]);
      return field.root;
    });
    return group("Squareness", ...fields);
  }

  private backlash(axes: Axis[]): HTMLElement {
    const fields = axes.map(({ axis, micro: unit }) => {
      const [low, high] = unit === "um" ? [-10, 40] : [-60, 240];
      const options = { label: axis, unit: micro(unit), value: 0, min: low, max: high, step: unit === "um" ? 0.1 : 0.5 };
      const field = slider(options, (value) => this.set(`axis.${axis}.backlash_${unit}`, value, micro(unit)));
      this.bound.push([field, () => this.axis(axis)?.backlash]);
      return field.root;
    });
    return group("Backlash", ...fields);
  }

  private temperature(): HTMLElement {
    const options = { label: "Axes at", unit: "°C", value: 20, min: 0, max: 50, step: 0.5, hint: "for display; not a setting of the machine" };
    const field = slider(options, (value) => display.set(value));
    this.bound.push([field, () => display.temperature_c ?? this.editor.shown?.reference_temperature_c]);
    return group("Temperature", field.root);
  }

  private ofAxis(axis: Axis): HTMLElement {
    const { axis: letter, micro: small, unit } = axis;
    const summary = () => this.editor.shown?.check.summary.axes.find((one) => one.axis === letter);
    const number = (label: string, unit: string, key: string, value: () => number | undefined): Child => {
      const field = numberField({ label, unit, value: 0 }, (value) => this.set(`axis.${letter}.${key}`, value, unit));
      this.ownBound.push([field, value]);
      return field.root;
    };
    const [name, long] = [unit === "deg" ? "deg" : "mm", length(unit)];
    const rotary = unit === "deg";
    return el(
      "div",
      { class: "settings" },
      group(
        `Settings of ${letter}`,
        choice("Between the points", [["cubic", "cubic"], ["linear", "linear"]], axis.interpolation, (value) => this.set(`axis.${letter}.interpolation`, value, "")).root,
        number("Largest correction", micro(small), `limits.magnitude_${small}`, () => summary()?.magnitude_micro),
        number("Its slope", `${long}/s`, `limits.slope_${name}_per_s`, () => summary()?.slope_per_s),
        number("Its acceleration", `${long}/s²`, `limits.acceleration_${name}_per_s2`, () => summary()?.acceleration_per_s2),
        number("Top feed", `${long}/min`, `max_feed_${name}_per_min`, () => this.axis(letter)?.max_feed_per_min),
        number("Expansion", rotary ? "µrad/rad/K" : "µm/m/K", `thermal.expansion_${rotary ? "urad_per_rad_k" : "um_per_m_k"}`, () => this.axis(letter)?.expansion),
      ),
    );
  }
}
