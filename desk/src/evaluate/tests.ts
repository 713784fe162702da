// The tests: their descriptions, the contents of their records, and the additional inputs they need.

import ring from "../../../records/ring.csv";
import spindle from "../../../records/spindle.csv";
import stepDiagonal from "../../../records/step-diagonal.csv";
import tracer from "../../../records/tracer.csv";
import { choice, textField, numberField, optionalField, tick, typed } from "../core/dom";
import { word } from "../core/shell";
import type { Test } from "./documents";

export type Value = number | string | boolean | null;

/** An option of a test, by its name on the command line. */
export interface Option {
  key: string;
  root: HTMLElement;
  /** Value of the control, for a file. */
  kept(): Value;
  open(value: Value): void;
  /** Value for the module. */
  given(): unknown;
  /** Value for the command line. */
  words(): string[];
}

export interface Described {
  title: string;
  /** Columns of a record; those in brackets may be left out. */
  columns: string;
  about: string;
  /** Whether the test needs the machine shown. */
  machine: boolean;
  options(again: () => void): Option[];
}

const flag = (key: string) => `--${key.replaceAll("_", "-")}`;

function optional(key: string, label: string, unit: string, placeholder: string, again: () => void): Option {
  const { root, input } = optionalField(label, unit, placeholder, again);
  const given = () => (input.value === "" ? null : input.valueAsNumber);
  return {
    key,
    root,
    kept: given,
    open: (value) => void (input.value = String(value ?? "")),
    given,
    words: () => (given() === null ? [] : [flag(key), String(given())]),
  };
}

/** An option that is a list; `numbers` describes the three numbers needed, if it is one of numbers. */
function list(key: string, label: string, placeholder: string, again: () => void, numbers?: string): Option {
  const { root, input } = textField(label, placeholder, again);
  return {
    key,
    root,
    kept: () => input.value,
    open: (value) => void (input.value = String(value ?? "")),
    given() {
      const parts = typed(input.value);
      if (numbers === undefined) return parts;
      if (parts.length === 0) return null;
      if (parts.length !== 3 || !parts.every((part) => Number.isFinite(Number(part)))) throw new Error(`${flag(key)}: found ${parts.join(",")}, needed ${numbers}`);
      return parts.map(Number);
    },
    words: () => (typed(input.value).length === 0 ? [] : [flag(key), word(typed(input.value).join(","))]),
  };
}

function pick(key: string, label: string, options: ReadonlyArray<readonly [string, string]>, first: string, again: () => void): Option {
  const { root, select } = choice(label, options, first, again);
  const given = () => select.value;
  return { key, root, kept: given, open: (value) => void (select.value = String(value)), given, words: () => [flag(key), given()] };
}

function ticked(key: string, label: string, again: () => void): Option {
  const { root, input } = tick(label, false, again);
  const given = () => input.checked;
  return { key, root, kept: given, open: (value) => void (input.checked = value === true), given, words: () => (given() ? [flag(key)] : []) };
}

function number(key: string, label: string, unit: string, first: number, again: () => void): Option {
  const { root, input } = numberField({ label, unit, value: first }, again);
  const given = () => input.valueAsNumber;
  return { key, root, kept: given, open: (value) => void (input.value = String(Number(value))), given, words: () => [flag(key), String(given())] };
}

/** Sample records that need no other machine than the one shown at the start. */
export const SAMPLES: Partial<Record<Test, { name: string; text: string }>> = {
  "step-diagonal": { name: "step-diagonal.csv", text: stepDiagonal },
  points: { name: "tracer.csv", text: tracer },
  probing: { name: "ring.csv", text: ring },
  thermal: { name: "spindle.csv", text: spindle },
};

export const TESTS: Record<Test, Described> = {
  "r-test": {
    title: "R-test, ISO 10791-6",
    columns: "x_mm,y_mm,z_mm[,a_deg][,b_deg][,c_deg],dx_um,dy_um,dz_um[,ball]",
    about: "One row per pose: commanded position under RTCP, and displacement of the tool from the ball on the table, actual − commanded. Gives the location errors of the rotary axes of the machine shown.",
    machine: true,
    options: (again) => [
      list("tool_mm", "Centre of the nest from the last tool-side frame / mm", "X, Y, Z: the machine's tool", again, "three numbers: X,Y,Z"),
      list("without", "Location errors that keep the machine's values", "none; as EX0C", again),
      ticked("free_sensor", "The nest was not calibrated to the spindle", again),
    ],
  },
  "step-diagonal": {
    title: "Diagonals and steps, ISO 230-6",
    columns: "diagonal[,run],direction,x_mm,y_mm,z_mm,deviation_um",
    about: "One row per reading: 1 to 4 for the body diagonal, 1 away from its first target or −1 back, commanded position, actual less commanded displacement along the beam. Gives squareness and scale; with steps the shapes of the errors.",
    machine: true,
    options: (again) => [optional("alignment_urad", "Standard uncertainty of the mirror's alignment", "µrad", "not known", again)],
  },
  points: {
    title: "Measured points",
    columns: "x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm[,u_um][,tool_x_mm,tool_y_mm,tool_z_mm]",
    about:
      "One row per point: commanded position, measured coordinates, their standard uncertainty, the reflector's offset. Points throughout a volume give the 21 errors of X, Y, Z of the machine shown; points in a plane or on a line affine terms, tables or a map. Drop a second record of a plane with the first to test whether these errors transfer.",
    machine: true,
    options: (again) => [
      list("nodes", "Nodes of the tables of X, Y, Z", "the levels of the points", again, "three numbers of 2 to 101"),
      list("without", "Angular errors left at zero", "none; as EBX", again),
    ],
  },
  probing: {
    title: "Probing, ISO 230-10",
    columns: "x_mm,y_mm[,z_mm][,run][,spindle_deg]",
    about: "One row per point: position of the centre of the stylus tip when the machine's own probe triggered, number of the measurement, orientation of the spindle. Gives form, repeatability, offset and diameter of the tip.",
    machine: false,
    options: (again) => [
      pick("feature", "Probed feature", [["ring", "a ring"], ["sphere", "a sphere"], ["point", "a point, again and again"]], "ring", again),
      optional("diameter_mm", "Calibrated diameter", "mm", "not known", again),
    ],
  },
  thermal: {
    title: "Thermal test, ISO 230-3",
    columns: "t_s[,position][,x1_um][,y1_um][,z_um][,x2_um][,y2_um][,ambient_c][,spindle_c][,machine_c]",
    about: "One row per reading: time, position of the axis that moves, displacements of the tool from the workpiece, temperatures. Gives the drift over stated periods.",
    machine: false,
    options: (again) => [
      pick("test", "Test", [["etve", "environment (ETVE)"], ["spindle", "rotating spindle"], ["axis", "moving linear axis"]], "spindle", again),
      number("period_min", "Period", "min", 60, again),
      optional("distance_mm", "Distance of the probes at both heights", "mm", "not known", again),
    ],
  },
};
