// The controls of a run's setup.

import type { Bench } from "../core/bench";
import { message } from "../core/desk";
import { choice, debounce, el, group, numberField, slider, type Field, type FieldOptions } from "../core/dom";
import type { Files } from "../core/machine";
import { toml, withSettings, type Direction, type Model, type Setup, type SettingsRead } from "./setup";

/** Figures of the drives in the machine's files, and the defaults of the settings. */
export interface Known {
  stated: boolean;
  friction: boolean;
  reference_temperature_c: number;
  drive: Record<string, number>;
}

/** Percent of the plugin's figures, and the settings of the simulated drive that they scale. */
const MISMATCH = [
  { label: "Gains of the drives", keys: ["position_gain_per_s", "velocity_gain_per_s"], min: 50, max: 200 },
  { label: "Friction", keys: ["coulomb_mm_per_s2"], min: 0, max: 300 },
  { label: "Pre-sliding", keys: ["presliding_mm"], min: 20, max: 300 },
] as const;

/** Tuned drives of the simulator by name. */
const VARIANTS = ["stiff", "usual", "soft", "worn"] as const;

interface Control {
  field: Field;
  /** Shows the settings. */
  show(): void;
}

export class Controls {
  readonly root: HTMLElement;
  private readonly controls: Control[] = [];
  private readonly hint: HTMLElement;
  private readonly model;
  private readonly orientation;
  private readonly variant;
  private readonly text: HTMLTextAreaElement;
  private readonly refused: HTMLElement;
  private files: Files | undefined;
  private defaults: Record<string, unknown> = {};
  private known: Known = { stated: false, friction: false, reference_temperature_c: 20, drive: {} };
  setup: Setup;

  constructor(
    private readonly bench: Bench,
    first: Setup,
    private readonly changed: () => void,
  ) {
    this.setup = structuredClone(first);
    const plain = (key: string, of: FieldOptions & { min: number; max: number }, factor = 1) => this.plain(key, of, factor);
    const motion = group(
      "Motion and surroundings",
      plain("motion.feed_percent", { label: "Feed", unit: "%", value: 100, min: 10, max: 300, step: 1 }),
      plain("rate_hz", { label: "Servo rate", unit: "Hz", value: 10_000, min: 500, max: 40_000, step: 100 }),
      plain("encoder.linear.noise_rms_mm", { label: "Encoder noise, RMS", unit: "µm", value: 0.005, min: 0, max: 1, step: 0.001 }, 1e3),
      plain("temperature_c", { label: "Temperature", unit: "°C", value: 20, min: -10, max: 60, step: 0.5 }),
    );
    this.hint = el("small", { class: "wide" });
    const drives = group("Drive mismatch", ...MISMATCH.map((one) => this.percent(one)), this.hint);
    this.variant = choice<string>("Drive", [["", "as the figures say"], ["common", "rigid (default)"], ...VARIANTS.map((name) => [name, name] as const)], "", (name) => void this.drive(name));
    const mechanics = group(
      "Mechanics of the drives",
      this.variant.root,
      plain("drive.resonance_hz", { label: "Resonance (0: none)", unit: "Hz", value: 0, min: 0, max: 400, step: 1 }),
      plain("drive.resonance_damping", { label: "Its damping", unit: "%", value: 3, min: 0.5, max: 20, step: 0.5 }, 100),
      plain("drive.gear_play_mm", { label: "Play", unit: "µm", value: 0, min: 0, max: 50, step: 1 }, 1e3),
    );
    this.model = choice<Model>("Error model", [["machine", "as the machine file says"], ["nine", "nine-term"], ["volumetric", "volumetric"]], "machine", (value) => this.take({ model: value }));
    this.orientation = choice<Direction>("Tool direction corrected", [["machine", "as the machine file says"], ["on", "on"], ["off", "off"]], "machine", (value) => this.take({ orientation: value }));
    const seed = this.number("seed", { label: "Seed of the noise", value: 1, min: 0, step: 1 });
    this.text = el("textarea", { rows: 4, spellcheck: "false", id: "scope-settings", onchange: () => void this.typed() });
    this.refused = el("p", { class: "warning", role: "alert" });
    const all = el("details", { class: "wide" }, el("summary", {}, "Every setting"), el("label", { for: "scope-settings" }, "Settings that are not the default, as in a scenario file (TOML)"), this.text, this.refused);
    this.root = el("div", { class: "setup" }, motion, drives, mechanics, group("Model and noise", this.model.root, this.orientation.root, seed, all));
  }

  /** Reads the defaults once, and the machine's figures of its drives. */
  async machine(files: Files): Promise<void> {
    // Redrawing the controls would discard text being typed.
    if (files === this.files) return;
    const [read, known] = await Promise.all([this.bench.call("scope_settings", "", "settings"), this.bench.call("scope_agreed", JSON.stringify(files))]);
    this.defaults = (JSON.parse(read) as SettingsRead).settings;
    this.known = JSON.parse(known) as Known;
    this.files = files;
    this.hint.textContent = this.known.stated
      ? `100 %: the simulated drives as the machine file states ${this.known.friction ? "drive and friction" : "the drive"} to the plugin`
      : "The machine file states no drive: 100 % is the simulator's default.";
    this.show();
  }

  /** Sets another setup, such as one from a link. */
  set(setup: Setup): void {
    this.setup = structuredClone(setup);
    this.show();
  }

  /** Takes the settings of a scenario file. */
  async scenario(text: string, file: string): Promise<void> {
    const read = JSON.parse(await this.bench.call("scope_settings", text, file)) as SettingsRead;
    this.set(withSettings(this.setup, read));
    this.changed();
  }

  /** Replaces the figures of all drives by those of a variant. */
  private async drive(name: string): Promise<void> {
    if (name === "") return;
    const text = name === "common" ? "" : `drive.variant = "${name}"`;
    const read = JSON.parse(await this.bench.call("scope_settings", text, "settings")) as SettingsRead;
    const others = Object.entries(this.setup.settings).filter(([key]) => !key.startsWith("drive."));
    const settings = Object.fromEntries([...others, ...read.changes.map(({ key, value }) => [key, value])]);
    this.set({ ...this.setup, settings });
    this.variant.value = name;
    this.changed();
  }

  private take(part: Partial<Setup>): void {
    this.setup = { ...this.setup, ...part };
    this.changed();
  }

  private show(): void {
    for (const control of this.controls) control.show();
    this.variant.value = "";
    this.model.value = this.setup.model;
    this.orientation.value = this.setup.orientation;
    this.text.value = toml({ ...this.setup, acts: [] });
    this.refused.textContent = "";
  }

  private async typed(): Promise<void> {
    try {
      const read = JSON.parse(await this.bench.call("scope_settings", this.text.value, "settings")) as SettingsRead;
      this.set({ ...withSettings(this.setup, read), acts: this.setup.acts });
      this.changed();
    } catch (error) {
      this.refused.textContent = message(error);
    }
  }

  /** Sets one setting, as its control does. */
  change(key: string, value: number): void {
    this.put({ [key]: value });
    for (const control of this.controls) control.show();
  }

  /** The temperature at which the machine was calibrated. */
  get reference_temperature_c(): number {
    return this.known.reference_temperature_c;
  }

  private put(values: Record<string, number | undefined>): void {
    const settings = { ...this.setup.settings };
    for (const [key, value] of Object.entries(values)) {
      if (value === undefined || value === this.standard(key)) delete settings[key];
      else settings[key] = decimal(value);
    }
    this.setup.settings = settings;
    this.variant.value = "";
    this.text.value = toml({ ...this.setup, acts: [] });
    this.soon();
  }

  private readonly soon = debounce(250, () => this.changed());

  /** The default of a setting. */
  private standard(key: string): number | undefined {
    if (key === "temperature_c") return this.known.reference_temperature_c;
    const value = key.split(".").reduce<unknown>((at, part) => (at as Record<string, unknown> | undefined)?.[part], this.defaults);
    return typeof value === "number" ? value : undefined;
  }

  private value(key: string): number {
    const own = this.setup.settings[key];
    return own === undefined ? (this.standard(key) ?? NaN) : Number(own.replaceAll("_", ""));
  }

  private plain(key: string, of: FieldOptions & { min: number; max: number }, factor: number): HTMLElement {
    const field = slider(of, (value) => this.put({ [key]: round(value / factor) }));
    this.controls.push({ field, show: () => (field.value = round(this.value(key) * factor)) });
    return field.root;
  }

  private number(key: string, of: FieldOptions): HTMLElement {
    const field = numberField(of, (value) => this.put({ [key]: value }));
    this.controls.push({ field, show: () => (field.value = this.value(key)) });
    return field.root;
  }

  private percent({ label, keys, min, max }: (typeof MISMATCH)[number]): HTMLElement {
    const whole = (key: string) => this.known.drive[key] ?? NaN;
    const field = slider({ label, unit: "%", value: 100, min, max, step: 0.1 }, (percent) =>
      this.put(Object.fromEntries(keys.map((key) => [`drive.${key}`, round((percent / 100) * whole(key))]))),
    );
    const first = keys[0];
    this.controls.push({ field, show: () => (field.value = Number(((100 * this.value(`drive.${first}`)) / whole(first)).toFixed(1))) });
    return field.root;
  }
}

/** Rounds away the binary error of a product. */
function round(value: number): number {
  return Number(value.toPrecision(12));
}

/** The value in TOML notation. */
function decimal(value: number): string {
  return String(value);
}
