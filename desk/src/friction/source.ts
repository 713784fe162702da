// Source of the record: a file, or circles simulated on the machine.

import { button, choice, el, group, numberField, type Field } from "../core/dom";
import { picker, plainName, text, type Given } from "../core/files";
import { word } from "../core/shell";

/** Circles and the simulated drives' true figures, by the keys of the simulator's settings. */
export interface Circles {
  plane: Plane;
  radius_mm: number;
  feeds_mm_per_min: [number, number];
  turns: number;
  set: Record<string, number>;
}

export type Plane = "XY" | "ZX" | "YZ";
export type Axes = "X,Y" | "Z,X" | "Y,Z" | "Y,X" | "X,Z" | "Z,Y";

export const PLANE_OF: Record<Axes, Plane> = { "X,Y": "XY", "Y,X": "XY", "Z,X": "ZX", "X,Z": "ZX", "Y,Z": "YZ", "Z,Y": "YZ" };
export const AXES_OF: Record<Plane, Axes> = { XY: "X,Y", ZX: "Z,X", YZ: "Y,Z" };

/** Settings of the simulation that concern friction: key, label, unit. */
const PLANT = [
  ["drive.coulomb_mm_per_s2", "Coulomb friction", "mm/s²"],
  ["drive.stribeck_share", "Stribeck share", ""],
  ["drive.stribeck_velocity_mm_per_s", "Stribeck velocity", "mm/s"],
  ["drive.presliding_mm", "Pre-sliding", "mm"],
  ["drive.viscous_per_s", "Viscous friction", "1/s"],
  ["axis.X.friction_factor", "X by a factor of", ""],
  ["axis.Y.friction_factor", "Y by a factor of", ""],
  ["axis.Z.friction_factor", "Z by a factor of", ""],
] as const;

/** Defaults: small circles, whose record is short, and not a multiple of the encoders' signal period. */
export const CIRCLES: Circles = { plane: "XY", radius_mm: 12.0037, feeds_mm_per_min: [1200, 500], turns: 1, set: {} };

/** Settings of the simulator, in sections. */
export type Settings = { [key: string]: number | Settings };

/** A setting by its key, `drive.presliding_mm`. */
function setting(settings: Settings, key: string): number {
  let found: number | Settings | undefined = settings;
  for (const part of key.split(".")) found = typeof found === "object" ? found[part] : undefined;
  if (typeof found !== "number") throw new Error(`the module has no setting ${key}`);
  return found;
}

export interface SourceEvents {
  record(name: string, text: string, axes: Axes): void;
  simulate(): void;
  stop(): void;
  save(): void;
  changed(): void;
  failed(error: unknown): void;
}

export class Source {
  readonly root: HTMLElement;
  readonly circles: Circles = structuredClone(CIRCLES);
  axes: Axes = "X,Y";
  private readonly fields: Field[];
  private readonly plant: { field: Field; key: string; usual: number }[];
  private readonly plane;
  private readonly chosen;
  private readonly buttons: Record<"simulate" | "stop" | "save", HTMLButtonElement>;

  /** `usual` are the simulator's default settings. */
  constructor(private readonly events: SourceEvents, usual: Settings) {
    const { circles } = this;
    this.chosen = choice<Axes>("Axes of the record, in the plane's sense", Object.keys(PLANE_OF).map((axes) => [axes as Axes, axes] as const), this.axes, (axes) => {
      this.axes = axes;
      events.changed();
    });
    const files = picker("Open a record", { accept: ".csv,.txt" }, (given) => this.take(given), (error) => events.failed(error));
    const number = (label: string, unit: string, value: number, take: (value: number) => void) =>
      numberField({ label, unit, value }, (typed) => {
        take(typed);
        events.changed();
      });
    this.plane = choice<Plane>("Plane", [["XY", "XY (G17)"], ["ZX", "ZX (G18)"], ["YZ", "YZ (G19)"]], circles.plane, (plane) => {
      circles.plane = plane;
      events.changed();
    });
    this.fields = [
      number("Radius", "mm", circles.radius_mm, (mm) => (circles.radius_mm = mm)),
      number("First feed", "mm/min", circles.feeds_mm_per_min[0], (feed) => (circles.feeds_mm_per_min[0] = feed)),
      number("Second feed", "mm/min", circles.feeds_mm_per_min[1], (feed) => (circles.feeds_mm_per_min[1] = feed)),
      number("Turns each way", "", circles.turns, (turns) => (circles.turns = turns)),
    ];
    this.plant = PLANT.map(([key, label, unit]) => {
      const usualValue = setting(usual, key);
      const field = number(label, unit, usualValue, (value) => {
        if (value === usualValue) delete circles.set[key];
        else circles.set[key] = value;
      });
      return { field, key, usual: usualValue };
    });
    this.buttons = {
      simulate: button("Simulate a record", () => events.simulate()),
      stop: button("Stop", () => events.stop(), { disabled: true }),
      save: button("Save the record", () => events.save(), { disabled: true }),
    };
    const { simulate, stop, save } = this.buttons;
    this.root = el(
      "div",
      { class: "source" },
      group("A record of yours", this.chosen.root, files, el("small", {}, "or drop RECORD.csv: t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm at an even 500 Hz or more")),
      group("Simulated circles", this.plane.root, ...this.fields.map(({ root }) => root), simulate, stop, save),
      group("True friction of the simulated drives, force by moved mass", ...this.plant.map(({ field }) => field.root)),
    );
  }

  /** Files that were dropped or opened. */
  take([file]: Given[]): void {
    if (!file) return;
    const content = text(file.bytes);
    if (content === undefined) this.events.failed(new Error(`${file.path}: found bytes that are not UTF-8, needed a CSV text`));
    else this.events.record(plainName(file.path), content, this.axes);
  }

  /** Enables the buttons that can be used. */
  enable(state: { busy: boolean; simulating: boolean; simulated: boolean }): void {
    this.buttons.simulate.disabled = state.busy;
    this.buttons.stop.disabled = !state.simulating;
    this.buttons.save.disabled = state.busy || !state.simulated;
  }

  /** Shows kept circles. */
  open(axes: Axes, kept: Circles): void {
    this.axes = this.chosen.value = axes;
    const { circles } = this;
    Object.assign(circles, structuredClone(kept));
    this.plane.value = circles.plane;
    [circles.radius_mm, ...circles.feeds_mm_per_min, circles.turns].forEach((value, i) => (this.fields[i]!.value = value));
    for (const { field, key, usual } of this.plant) field.value = circles.set[key] ?? usual;
  }
}

/** The request that the module takes. */
export function request(circles: Circles, pass: "record" | "before" | "after"): string {
  const { set, ...rest } = circles;
  return JSON.stringify({ ...rest, pass, set: Object.entries(set).map(([key, value]) => [key, String(value)]) });
}

/** The command line that simulates these circles. */
export function simulator(circles: Circles, machine: string, findDrive: boolean): string {
  const { plane, radius_mm, feeds_mm_per_min, turns, set } = circles;
  return [
    "firmware-sim friction",
    `--machine ${word(machine)}`,
    ...(plane === "XY" ? [] : [`--plane ${plane}`]),
    `--radius-mm ${radius_mm}`,
    `--feeds ${feeds_mm_per_min.join(",")}`,
    `--turns ${turns}`,
    ...(findDrive ? [] : ["--given-drive"]),
    ...Object.entries(set).map(([key, value]) => `--set ${key}=${value}`),
  ].join(" ");
}
