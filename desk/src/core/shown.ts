// A result as the module describes it, in tables.

import { bars, notes, table } from "./dom";
import type { Shown, Table } from "./shown-types";

/** A table of a result. */
export function tabled({ caption, header, rows, bars: column }: Table): HTMLElement {
  const of = table(caption, header, rows);
  const share = (cell: Table["rows"][number][number] | undefined) => (typeof cell === "object" ? cell.value / 100 : 0);
  if (column !== null) bars(of, rows.map((row) => share(row[column])));
  return of;
}

/** Notes and tables of a result. */
export function showTables(host: HTMLElement, shown: Shown): void {
  host.replaceChildren(notes("Notes", shown.notes), ...shown.tables.map(tabled));
}
