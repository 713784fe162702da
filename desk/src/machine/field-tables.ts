// The field in numbers: figures, causes of the worst point, every point.

import { button, el, table, type Cell } from "../core/dom";
import { save } from "../core/files";
import { cell, fixed } from "../core/number";
import { millimetres, modelName, type Case, type Figures, type Left, type Model, type Rows, type Worst } from "./field-document";

/** Rows of the table of points; the CSV has them all. */
const TABLE_ROWS = 300;

/** Before, after nine terms, after the volumetric form. */
export function figuresTable(figures: Figures): HTMLElement {
  const header = ["Error of the tip", "largest / µm", "RMS / µm", "95 % / µm", "range X / µm", "range Y / µm", "range Z / µm", "tool turned, largest / µrad", "points limited"];
  const row = (name: string, found: Case, limited: Cell): Cell[] => [
    name,
    cell(found.largest_um),
    cell(found.rms_um),
    cell(found.p95_um),
    ...found.range_um.map(([low, high]) => cell(high - low)),
    cell(found.orientation.largest_urad, 2),
    limited,
  ];
  const left = (model: Model, { after, limited_points }: Left): Cell[][] =>
    after ? [row(`after, ${modelName[model]}`, after, cell(limited_points, 0))] : [];
  const rows = [row("before", figures.before, "–"), ...left("nine", figures.nine), ...left("volumetric", figures.volumetric)];
  const refused = ([["nine", figures.nine], ["volumetric", figures.volumetric]] as const)
    .filter(([, one]) => one.refused)
    .map(([model, one]) => el("p", { class: "warning" }, `${modelName[model]}: ${one.refused}`));
  return el("div", {}, table(`Figures over ${figures.points.join(" × ")} points`, header, rows), ...refused);
}

/** The sentence above the pictures. */
export function summary(figures: Figures): string {
  const parts = [`${figures.machine} (${figures.chain}) at ${fixed(figures.temperature_c, 1)} °C.`, `Before: ${sentence(figures.before.worst)}.`];
  const after = figures[figures.model].after;
  if (after) parts.push(`After, ${modelName[figures.model]}: ${sentence(after.worst)}.`);
  if (Object.keys(figures.travel_deg).length > 0)
    parts.push(figures.corrects_orientation && figures.model === "volumetric" ? "The rotary axes turn the tool back." : "The rotary axes are not corrected for the tool's direction.");
  if (figures.clamped_points > 0) parts.push(`${figures.clamped_points} ${figures.clamped_points === 1 ? "point is" : "points are"} beyond the end of a table, where its edge value is used.`);
  return parts.join(" ");
}

function sentence(worst: Worst): string {
  const at = worst.at_mm.map((mm, axis) => `${"XYZ"[axis]} ${millimetres(mm)}`).join(", ");
  const [first] = worst.terms;
  const cause = first && first.along_um > 0 ? `, the largest share from ${first.term} (${fixed(first.along_um, 2)} µm)` : "";
  return `worst ${fixed(worst.size_um, 3)} µm at ${at} mm${cause}`;
}

/** The tables, and their terms, that cause the error at the worst point. */
export function causes(title: string, worst: Worst): HTMLElement {
  const numbers = ({ error_um, along_um }: { error_um: readonly number[]; along_um: number }): Cell[] => [
    ...error_um.map((um) => cell(um)),
    cell(along_um),
    worst.size_um > 0 ? cell((100 * along_um) / worst.size_um, 1) : "–",
  ];
  const columns = ["ΔX / µm", "ΔY / µm", "ΔZ / µm", "along the error / µm", "share / %"];
  const tables = worst.tables.map((one) => [one.source.length === 1 ? `table of ${one.source}` : one.source, ...numbers(one)]);
  const terms = worst.terms.map((one) => [one.term, ...numbers(one)]);
  const whole: Cell[] = ["whole error", ...worst.error_um.map((um) => cell(um)), cell(worst.size_um), cell(100, 1)];
  const at = worst.at_mm.map((mm, axis) => `${"XYZ"[axis]} ${millimetres(mm)}`).join(", ");
  return el(
    "div",
    {},
    table(`${title}: which table causes it, at ${at} mm`, ["Table", ...columns], [...tables, whole]),
    el("details", {}, el("summary", {}, `Terms of the tables (${terms.length})`), table(`${title}: terms, the largest first`, ["Term", ...columns], terms)),
  );
}

/** The correction sent at the worst point. */
export function sent(title: string, worst: Worst): HTMLElement {
  const rows = worst.at_mm.map((mm, axis) => [`${"XYZ"[axis]}`, cell(mm), cell(worst.correction[axis]!, 6)]);
  return table(`${title}: correction sent`, ["Axis", "command / mm", "correction / mm"], rows);
}

/** Every point, behind a disclosure. */
export class PointsTable {
  private rows: Rows | undefined;
  private readonly body = el("div", { class: "rows", tabindex: 0, role: "group", "aria-label": "Points of the field: numbers" });
  private readonly root: HTMLDetailsElement;

  constructor(host: HTMLElement) {
    this.root = el("details", { ontoggle: () => this.fill() }, el("summary", {}, "All points"), this.body, button("Save points as CSV", () => this.save()));
    host.append(this.root);
  }

  show(rows: Rows): void {
    this.rows = rows;
    this.fill();
  }

  private fill(): void {
    if (!this.root.open || !this.rows) return;
    const { all, count } = this.rows;
    const every = Math.max(1, Math.ceil(count / TABLE_ROWS));
    const lines: Cell[][] = [];
    for (let i = 0; i < count; i += every) {
      const row = Array.from(all.subarray(9 * i, 9 * i + 9));
      const sizes = [this.rows.sizesOf("before")[i]!, this.rows.sizesOf("after")[i]!];
      lines.push([String(i), ...row.slice(0, 3).map((mm) => cell(mm)), ...row.slice(3, 6).map((um) => cell(um)), cell(sizes[0]), ...row.slice(6).map((um) => cell(um)), cell(sizes[1])]);
    }
    const header = ["Point", "X / mm", "Y / mm", "Z / mm", ...["before", "after"].flatMap((half) => [`ΔX ${half} / µm`, `ΔY ${half} / µm`, `ΔZ ${half} / µm`, `size ${half} / µm`])];
    const caption = every > 1 ? `Points of the field: one in ${every} of ${count}` : "Points of the field";
    this.body.replaceChildren(table(caption, header, lines));
  }

  private save(): void {
    if (!this.rows) return;
    const { all, count } = this.rows;
    const lines = ["x_mm,y_mm,z_mm,ex_before_um,ey_before_um,ez_before_um,ex_after_um,ey_after_um,ez_after_um"];
    for (let i = 0; i < count; i++) lines.push(all.subarray(9 * i, 9 * i + 9).join(","));
    save("field.csv", `${lines.join("\n")}\n`, "text/csv");
  }
}
