// The most important figure of a result as a sentence, which stands above its plots.

import type { Cell, Shown, Table } from "./shown-types";

const text = (cell: Cell | undefined) => (typeof cell === "object" ? cell.text : (cell ?? ""));
const number = (cell: Cell | undefined) => (typeof cell === "object" ? cell.value : Number.NaN);

/** A column by the beginning of its heading. */
function column({ header }: Table, name: string): number {
  return header.findIndex((heading) => heading.startsWith(name));
}

/** Headings of the column of values. */
const VALUES = ["value", "found", "left by the tables", "to"];

/** Columns of value, expanded uncertainty and unit; −1 for none. */
function columns(table: Table): [value: number, expanded: number, unit: number] {
  const values = VALUES.map((heading) => column(table, heading)).filter((at) => at > 0);
  return [values[0] ?? -1, column(table, "±"), column(table, "unit")];
}

/** A value of a table with its uncertainty and unit, by the beginning of its row's name. */
function valueOf(tables: readonly Table[], name: string): string {
  for (const table of tables) {
    const [value, expanded, unit] = columns(table);
    const row = table.rows.find(([first]) => `${text(first)} `.startsWith(`${name} `));
    if (value < 0 || !row) continue;
    const known = expanded > 0 && text(row[expanded]) !== "–" ? ` ± ${text(row[expanded])}` : "";
    return ` (${text(row[value])}${known}${unit > 0 ? ` ${text(row[unit])}` : ""})`;
  }
  return "";
}

/** The largest of the shares: "backlash X (5.01 ± 0.13 µm) is 50.3 % of the deviation: correct it first." */
export function largestShare({ tables }: Shown, of: string, advice: string): string {
  const shares = tables.find(({ bars }) => bars !== null);
  const [first] = shares?.rows ?? [];
  if (!shares || !first) return "";
  const name = text(first[0]);
  return `${name}${valueOf(tables, name)} is ${text(first[shares.bars!])} % of ${of}: ${advice}.`;
}

/** The error that is largest compared with its uncertainty, or the largest figure of a test that states none. */
export function clearest({ result, tables }: Shown): string {
  if (result !== "") return result;
  for (const table of tables) {
    const [value, expanded, unit] = columns(table);
    // Sizes in mm, such as a radius, are known by many times their uncertainty and are no errors.
    const known = table.rows.filter((row) => number(row[expanded]) > 0 && Number.isFinite(number(row[value])) && text(row[unit]) !== "mm");
    const ratio = (row: readonly Cell[]) => Math.abs(number(row[value])) / number(row[expanded]);
    const most = largest(known, ratio);
    if (most && unit > 0) return `${text(most[0])} is ${text(most[value])} ± ${text(most[expanded])} ${text(most[unit])}, the clearest of ${known.length}.`;
  }
  const table = tables.find((table) => column(table, "unit") > 0);
  if (!table) return first(tables);
  const value = Math.max(1, columns(table)[0]);
  const most = largest(table.rows.filter((row) => Number.isFinite(number(row[value]))), (row) => number(row[value]));
  const heading = table.header[value];
  return most ? `${text(most[0])}${heading === "value" ? "" : `, ${heading}`}: ${text(most[value])} ${text(most[column(table, "unit")])}.` : "";
}

/** The first figure of tables that have their unit in the heading: "Roundness of the mean of 8 revolutions, LSC: 1.234 µm." */
function first(tables: readonly Table[]): string {
  const table = tables.find(({ header: [, heading] }) => heading?.endsWith(", µm"));
  const [row] = table?.rows ?? [];
  return row ? `${table!.caption}, ${text(row[0])}: ${text(row[1])} µm.` : "";
}

/** What a model leaves of a drift that it did not see. */
export function heldOut({ result, tables }: Shown): string {
  const table = tables.find((table) => column(table, "largest drift") > 0);
  if (!table) return result;
  const [drift, left, use] = ["largest drift", "left", "use"].map((heading) => column(table, heading)) as [number, number, number];
  const worst = largest(table.rows.filter((row) => text(row[use]) === "held out"), (row) => number(row[left]));
  return worst ? `In cycles that the model did not see it leaves at most ${text(worst[left])} of ${text(worst[drift])} µm of drift (${text(worst[0])}).` : result;
}

/** The row of the largest size. */
function largest(rows: readonly (readonly Cell[])[], size: (row: readonly Cell[]) => number): readonly Cell[] | undefined {
  return rows.reduce<readonly Cell[] | undefined>((best, row) => (best && size(best) >= size(row) ? best : row), undefined);
}
