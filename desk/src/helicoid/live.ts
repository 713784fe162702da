// Figures of one point of the flank, of the whole flank, and of the travel.

import { el, table, type Cell } from "../core/dom";
import { cell, fixed, significant } from "../core/number";
import type { Limits, Reach, Tool } from "./documents";

const DECIMALS = 6;

/** Both branches side by side. */
export function displacements(tool: Tool, limits: Limits): HTMLElement {
  const [first, second] = tool.stands;
  const ends = (letter: keyof Limits) => {
    const limit = limits[letter];
    return limit ? `${fixed(limit[0], 0)} to ${fixed(limit[1], 0)}` : "not limited";
  };
  const said = (letter: string) => {
    const beyond = tool.stands.filter((pose) => pose.beyond.some((one) => one.axis === letter)).map((pose) => `branch ${pose.branch}`);
    return beyond.length > 0 ? `${beyond.join(" and ")} beyond it` : "";
  };
  const row = (letter: keyof Limits, unit: string, one: number, other: number): Cell[] => [`${letter} / ${unit}`, cell(one, DECIMALS), cell(other, DECIMALS), ends(letter), said(letter)];
  const rows: Cell[][] = [
    row("X", "mm", first.x_mm, second.x_mm),
    row("Y", "mm", first.y_mm, second.y_mm),
    row("Z", "mm", first.z_mm, second.z_mm),
    row("A", "degrees", first.a_deg, second.a_deg),
    row("C", "degrees", first.c_deg, second.c_deg),
    ["Tip off the flank / µm", small(first.off_surface_um), small(second.off_surface_um), "by the step's forward transformation", ""],
    ["Tool off the normal / µrad", small(first.off_normal_urad), small(second.off_normal_urad), "by the step's forward transformation", ""],
  ];
  return table("Displacements of the five axes", ["", "Branch 1", "Branch 2", "Travel", ""], rows);
}

function small(value: number): Cell {
  return { text: value.toExponential(1).replace("-", "−"), value };
}

/** Where the tool is, and how far from the singular pose. */
export function place(tool: Tool): HTMLElement {
  const list = (values: readonly number[], decimals: number) => values.map((value) => fixed(value, decimals)).join(", ");
  const { margin_deg, a_deg, gain, fade_deg, near } = tool.singular;
  const singular = `The singular pose, tool along the C axis, is at A = ${fixed(a_deg, 0)}°: ${significant(margin_deg, 5)}° away; turning the tool by 1 µrad turns C by up to ${significant(gain, 3)} µrad.`;
  return el("div", {},
    el("p", { class: "said" }, `Tip at [${list(tool.point_mm, 4)}] mm of the gear, radius ${fixed(tool.radius_mm, 4)} mm; outward normal [${list(tool.normal, 6)}].`),
    el("p", near ? { class: "warning", role: "status" } : { class: "said" }, near ? `${singular} Nearer than ${fixed(fade_deg, 0)}°: the correction of the tool's direction fades.` : singular));
}

/** Travel over the grid on one branch. */
export function travel({ branch, axes }: Reach): HTMLElement {
  const rows = axes.map(({ axis, unit, low, high, limit, beyond }): Cell[] => [
    `${axis} / ${unit}`,
    cell(low),
    cell(high),
    limit ? `${fixed(limit[0], 0)} to ${fixed(limit[1], 0)}` : "–",
    beyond > 0 ? { text: `${beyond} ${beyond === 1 ? "point" : "points"} beyond`, value: beyond } : "within",
  ]);
  return table(`Travel over the grid, branch ${branch}`, ["", "From", "To", "Travel", ""], rows);
}
