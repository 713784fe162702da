// The form's inputs as the module's request and as a command line.

export interface Span {
  start: number;
  stop: number;
  count: number;
}

/** The fields of the view. */
export interface Inputs {
  source: "gear" | "base";
  module_mm: number;
  teeth: number;
  pressure_angle_deg: number;
  helix_angle_deg: number;
  base_radius_mm: number;
  lead_parameter_mm_per_rad: number;
  flank: "right" | "left";
  form: "vertical" | "horizontal";
  pivot: "length" | "finder";
  pivot_mm: number;
  edge_finder_mm: number;
  edge_finder_radius_mm: number;
  branch: 1 | 2;
  direction_a: 1 | -1;
  direction_c: 1 | -1;
  work_offset_mm: [number, number, number];
  u: Span;
  theta: Span;
  feed_mm_per_min: number;
  clearance_mm: number;
  passes: "theta" | "u";
}

/** Initial values of the view; feed, clearance and passes are the command line's defaults. */
export const START: Inputs = {
  source: "gear",
  module_mm: 3,
  teeth: 24,
  pressure_angle_deg: 20,
  helix_angle_deg: 15,
  base_radius_mm: 36,
  lead_parameter_mm_per_rad: 130,
  flank: "right",
  form: "vertical",
  pivot: "length",
  pivot_mm: 150,
  edge_finder_mm: 145,
  edge_finder_radius_mm: 5,
  branch: 1,
  direction_a: 1,
  direction_c: 1,
  work_offset_mm: [0, 0, 0],
  u: { start: 0.1, stop: 0.6, count: 6 },
  theta: { start: 0, stop: 0.2, count: 9 },
  feed_mm_per_min: 500,
  clearance_mm: 50,
  passes: "theta",
};

type Value = number | string | readonly number[];

/** The options that differ from the command line's own defaults, by their names there. */
function options(inputs: Inputs): [string, Value][] {
  const chosen: [string, Value][] = [];
  const take = (...names: (keyof Inputs)[]) => chosen.push(...names.map((name): [string, Value] => [name, inputs[name] as Value]));
  if (inputs.source === "gear") take("module_mm", "teeth", "pressure_angle_deg", "helix_angle_deg");
  else take("base_radius_mm", "lead_parameter_mm_per_rad");
  const range = ({ start, stop, count }: Span) => `${start}:${stop}:${count}`;
  chosen.push(["u_rad", range(inputs.u)], ["theta_rad", range(inputs.theta)]);
  if (inputs.form !== "horizontal") take("form");
  if (inputs.pivot === "length") take("pivot_mm");
  else take("edge_finder_mm", "edge_finder_radius_mm");
  if (inputs.branch !== 1) take("branch");
  if (inputs.flank !== "right") take("flank");
  if (inputs.work_offset_mm.some((value) => value !== 0)) take("work_offset_mm");
  if (inputs.direction_a !== 1) take("direction_a");
  if (inputs.direction_c !== 1) take("direction_c");
  if (inputs.feed_mm_per_min !== START.feed_mm_per_min) take("feed_mm_per_min");
  if (inputs.clearance_mm !== START.clearance_mm) take("clearance_mm");
  if (inputs.passes !== "theta") take("passes");
  return chosen;
}

/** The module's request. */
export function request(inputs: Inputs): string {
  return JSON.stringify(Object.fromEntries(options(inputs)));
}

/** The request for one line or one point of the flank. */
export function narrowed(inputs: Inputs, u: Span, theta: Span): string {
  return request({ ...inputs, u, theta });
}

/** The command line that gives the same result. */
export function command(inputs: Inputs): string {
  const words = options(inputs).map(([name, value]) => `--${name.replaceAll("_", "-")} ${String(value)}`);
  return ["trueaxis helicoid", ...words, "--gcode helicoid.ngc", "-o helicoid.csv"].join(" ");
}
