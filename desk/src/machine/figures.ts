// Figures of the machine: warnings, accuracy, limits, margins, the compiled file.

import { el, notes, numberField, section, table, type Cell } from "../core/dom";
import { cell, fixed } from "../core/number";
import { tabled, tabledAll } from "../core/shown";
import { length, micro, type Shown } from "./document";
import type { Editor } from "./editor";

/** The warnings, beside the settings that cause them. */
export function warnings(editor: Editor): HTMLElement {
  const list = el("ul", { class: "warnings" });
  const said = el("p", { role: "status" });
  editor.subscribe(() => {
    const all = editor.shown?.check.warnings ?? [];
    const notes = editor.shown?.notes ?? [];
    said.textContent = all.length === 0 ? "No errors, no warnings." : `No errors, ${all.length === 1 ? "1 warning" : `${all.length} warnings`}:`;
    list.replaceChildren(...all.map((text) => el("li", { class: "warning" }, text)), ...notes.map((text) => el("li", {}, text)));
  });
  return section("Check", said, list);
}

/** The compiled file in a line or two. */
export function identity(editor: Editor): HTMLElement {
  const place = el("dl", { class: "identity" });
  editor.subscribe(() => {
    const of = editor.shown?.check.summary;
    if (!of) return;
    const hex = (value: number) => value.toString(16).padStart(8, "0");
    const kib = (bytes: number) => fixed((of.memory_scalars * bytes) / 1024, 1);
    const pairs: [string, string][] = [
      ["machine", of.name],
      ["chain", of.chain],
      ["id", hex(of.machine_id)],
      ["CRC", hex(of.crc)],
      ["error model", of.model === "nine" ? "nine-term" : "volumetric"],
      ["exact inverse", `${of.inverse_passes} look-ups`],
      ["memory", `${of.memory_scalars} scalars: ${kib(8)} KiB in f64, ${kib(4)} KiB in f32`],
    ];
    place.replaceChildren(...pairs.map(([name, value]) => el("div", {}, el("dt", {}, name), el("dd", {}, value))));
  });
  return place;
}

/** Corrections against their limits, at a feed and a servo rate. */
export function limits(editor: Editor): HTMLElement {
  const feed = numberField({ label: "Feed of all axes", unit: "mm/min, °/min", value: 0, min: 0, hint: "0: the top feed of each axis" }, (value) => {
    editor.feed_per_min = value;
    void editor.refresh();
  });
  const rate = numberField({ label: "Servo rate", unit: "Hz", value: editor.rate_hz }, (value) => {
    editor.rate_hz = value;
    void editor.refresh();
  });
  const place = el("div", { class: "tables" });
  editor.subscribe(() => {
    rate.value = editor.rate_hz;
    feed.value = editor.feed_per_min;
    if (editor.shown) place.replaceChildren(rates(editor.shown), ...margins(editor.shown));
  });
  return section("Corrections and their limits", el("div", { class: "row" }, feed.root, rate.root), place);
}

function rates(shown: Shown): HTMLElement {
  const header = ["Axis", "Largest table error", "Magnitude limit", "Slope", "Slope limit", "Most of it from", "Acceleration", "Acceleration limit", "Lost motion", "Applied within / ms"];
  const rows = shown.axes.map(({ axis, unit, micro: small, correction }): Cell[] => {
    const summary = shown.check.summary.axes.find((one) => one.axis === axis);
    const errors = summary?.table?.errors.filter((one) => one.unit === small).map((one) => one.max_abs) ?? [];
    const lost = shown.check.lost_motion.find((one) => one.axis === axis);
    const [long, little] = [length(unit), micro(small)];
    const number = (value: number | null | undefined, of: string, decimals: number): Cell =>
      value === null || value === undefined ? "–" : { text: `${fixed(value, decimals)} ${of}`, value };
    return [
      axis,
      errors.length ? number(Math.max(...errors), little, 2) : "no table",
      number(summary?.magnitude_micro, little, 1),
      number(correction?.rate, `${long}/s`, 4),
      number(summary?.slope_per_s, `${long}/s`, 2),
      correction?.moving ?? "–",
      correction && correction.acceleration === null ? "steps (linear)" : number(correction?.acceleration, `${long}/s²`, 2),
      number(summary?.acceleration_per_s2, `${long}/s²`, 0),
      number((lost?.play_um ?? lost?.play_urad) as number | undefined, little, 1),
      cell(lost?.lead_in_ms as number | undefined, 1),
    ];
  });
  const levers = shown.check.summary.model === "volumetric" ? "; accelerations without the levers of the angular errors" : "";
  return table(`Upper bounds, all axes at the feed at once${levers}`, header, rows);
}

function margins(shown: Shown): HTMLElement[] {
  const all = shown.check.feedback_margins;
  if (all.length === 0) return [];
  const header = ["Axis", "Phase margin / °", "Gain margin / dB", "Largest K_p", "Largest K_i / 1/s"];
  const rows = all.map((of): Cell[] => [
    of.axis,
    cell(of.phase_margin_deg, 1),
    cell(of.gain_margin_db, 1),
    cell(of.largest_proportional, 2),
    cell(of.largest_integral_per_s, 1),
  ]);
  return [table("Margins of the contour feedback", header, rows)];
}

/** Figures after ISO 230-2, of measurements and of the tables themselves. */
export function accuracy(editor: Editor): HTMLElement {
  const place = el("div", { class: "tables" });
  editor.subscribe(() => editor.shown && place.replaceChildren(...iso(editor.shown)));
  return section("Accuracy after ISO 230-2:2014", place);
}

function iso({ measurements, accuracy }: Shown): HTMLElement[] {
  const parts = measurements.flatMap(({ file, figures, refused }) => {
    if (!figures) return [el("p", {}, refused ?? file)];
    const [first, ...others] = figures.tables;
    return [tabled({ ...first!, caption: `${file}: ${figures.title}, ${figures.summary.join(", ")}` }), ...tabledAll(others), notes("Notes", figures.notes)];
  });
  return accuracy.header.length > 1 ? [...parts, tabled(accuracy)] : parts;
}
