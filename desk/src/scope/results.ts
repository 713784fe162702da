// Figures of a run, and of the run kept for comparison.

import { el, table, type Cell } from "../core/dom";
import { cell, fixed, significant } from "../core/number";
import { faultInWords } from "./words";
import { KINDS, type Figures, type Kind, type Progress, type Size } from "./documents";
import type { Rows } from "./rows";
import { exchangeOf } from "./setup";
import { time as startOf } from "./times";

/** A run's figures and its progress. */
export interface Result {
  progress: Progress;
  figures: Figures;
}

const ALL = Object.keys(KINDS) as Kind[];

/** Contour errors, digests, counts and faults; with a kept run both and their difference. */
export function results(run: Result, kept: Result | undefined): HTMLElement {
  const { figures } = run;
  const root = el("div", { class: "results" });
  const [own, other] = [known(run), kept && known(kept)];
  root.append(sizes("Contour error of the true tip while cutting / µm", own(figures.contour_error_um), kept && other?.(kept.figures.contour_error_um)));
  if (figures.orientation_error_urad) root.append(sizes("Angle of the tool from its direction while cutting / µrad", own(figures.orientation_error_urad), kept && other?.(kept.figures.orientation_error_urad ?? {})));
  root.append(digests(run, kept), counts(run, kept));
  if (figures.notes.length > 0) root.append(el("ul", { "aria-label": "Notes on the run" }, ...figures.notes.map((note) => el("li", {}, note))));
  if (figures.faults.length > 0) root.append(faults(figures));
  return root;
}

/** Largest contour errors in a sentence; empty before the first cut. */
export function sentence(run: Result): string {
  const sizes = known(run)(run.figures.contour_error_um);
  const parts = ALL.flatMap((kind) => (sizes[kind] && Number.isFinite(sizes[kind].max) ? [`${KINDS[kind].text} ${significant(sizes[kind].max, 3)} µm`] : []));
  return parts.length === 0 ? "" : `Largest contour error while cutting${run.progress.done ? "" : " so far"}: ${parts.join(", ")}.`;
}

/** Time after an exchange that the correction takes to its new value, s. */
const SETTLED_S = 0.3;

/** Largest contour errors before and after the last exchange of the tables in motion, in a sentence; `done`: the run has ended. */
export function exchanged(rows: Rows, acts: readonly string[], done: boolean): string {
  const time = rows.column("time_s");
  const now = time.at(-1) ?? 0;
  const times = acts.filter((act) => exchangeOf(act) !== undefined).map((act) => startOf(act)).sort((one, other) => one - other);
  const at = times.findLast((time) => time <= now);
  if (at === undefined || at === 0) return "";
  const previous = times.findLast((time) => time < at);
  const [cutting, errors] = [rows.column("cutting"), rows.column("compensated.error_um")];
  const most = (from: number, to: number) => errors.reduce((most, error, row) => (cutting[row]! > 0 && time[row]! >= from && time[row]! < to && error > most ? error : most), 0);
  const [before, after] = [most(previous === undefined ? 0 : previous + SETTLED_S, at), most(at + SETTLED_S, Infinity)];
  if (before === 0 || after === 0) return "";
  return `Tables exchanged at ${significant(at, 3)} s: the largest corrected contour error ${after < before ? "falls" : "rises"} from ${significant(before, 3)} to ${significant(after, 3)} µm${done ? "" : " so far"}.`;
}

type Sizes = Partial<Record<Kind, Size>>;

/** Figures of a run; those of a run that has not cut yet are not known. */
function known({ progress }: Result): (sizes: Sizes) => Sizes {
  const unknown = (size: Size) => !progress.done && size.max === 0;
  return (sizes) => Object.fromEntries(Object.entries(sizes).map(([kind, size]) => [kind, unknown(size) ? { max: NaN, rms: NaN } : size]));
}

function sizes(caption: string, own: Sizes, kept: Sizes | undefined): HTMLElement {
  const kinds = ALL.filter((kind) => own[kind] ?? kept?.[kind]);
  const both = (of: Sizes, kind: Kind): Cell[] => [cell(of[kind]?.max), cell(of[kind]?.rms)];
  if (!kept) return table(caption, ["machine", "largest", "RMS"], kinds.map((kind) => [KINDS[kind].text, ...both(own, kind)]));
  const less = (kind: Kind, part: keyof Size): Cell => (own[kind] && kept[kind] ? cell(own[kind][part] - kept[kind][part]) : "–");
  const rows = kinds.map((kind): Cell[] => [KINDS[kind].text, ...both(kept, kind), ...both(own, kind), less(kind, "max"), less(kind, "rms")]);
  return table(`${caption}, A beside B`, ["machine", "A largest", "A RMS", "B largest", "B RMS", "B − A largest", "B − A RMS"], rows);
}

function digests(run: Result, kept: Result | undefined): HTMLElement {
  const all = kept ? [kept, run] : [run];
  const kinds = ALL.filter((kind) => all.some(({ figures }) => figures.digest[kind]));
  const names = kept ? ["A", "B"] : ["digest"];
  const heads = all.map(({ progress }, i) => `${names[i]}${progress.done ? "" : " so far"}`);
  const rows = kinds.map((kind) => {
    const cells = all.map(({ figures, progress }) => el("td", {}, el("code", {}, (progress.cycle > 0 && figures.digest[kind]) || "–")));
    return el("tr", {}, el("th", { scope: "row" }, KINDS[kind].text), ...cells);
  });
  return el(
    "table",
    {},
    el("caption", {}, "Digest of the step: the same for the same bits in every cycle"),
    el("thead", {}, el("tr", {}, ...["machine", ...heads].map((name) => el("th", { scope: "col" }, name)))),
    el("tbody", {}, ...rows),
  );
}

function counts(run: Result, kept: Result | undefined): HTMLElement {
  const whole = (value: number): Cell => ({ text: value.toLocaleString("en"), value });
  const all = kept ? [kept, run] : [run];
  const rows: Cell[][] = [
    ["cycles", ...all.map(({ progress }) => whole(progress.cycle))],
    ["correction limited / cycles", ...all.map(({ figures }) => whole(figures.limited_cycles))],
    ["stopped by the step", ...all.map(({ figures }) => (figures.stopped ? "yes" : "no"))],
  ];
  return table("The corrected machine", ["", ...(kept ? ["A", "B"] : ["run"])], rows);
}

function faults(figures: Figures): HTMLElement {
  const rows = figures.faults.map(({ time_s, fault, axis, line, cycles }): Cell[] => [fixed(time_s, 4), `${faultInWords(fault, axis)} `, String(line), String(cycles)]);
  const root = table("Faults that the step reported, corrected", ["time / s", "fault", "line", "cycles"], rows);
  figures.faults.forEach(({ fault }, row) => root.tBodies[0]!.rows[row]!.cells[1]!.append(el("small", {}, el("code", {}, fault))));
  return root;
}
