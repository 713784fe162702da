// The table columns of one error, and their points.

import { length, micro, type Axis, type Column } from "./document";
import type { PointsOf } from "./handles";

/** The columns of an error in the table of an axis: one, or one per direction; not that of its uncertainty. */
export function columnsOf(axis: Axis | undefined, component: number): Column[] {
  return axis?.table?.columns.filter((column) => column.component === component && (column.forward || column.reverse)) ?? [];
}

/** Their points. */
export function pointsOf(axis: Axis, component: number): PointsOf[] {
  const { table } = axis;
  if (!table) return [];
  const at = table.columns.findIndex((column) => column.component === null);
  const own = "XYZABC"[component] === axis.axis;
  return columnsOf(axis, component).map((column) => {
    const index = table.columns.indexOf(column);
    return {
      column: column.name,
      direction: column.forward ? "forward" : "reverse",
      unit: micro(component < 3 ? "um" : "urad"),
      positionUnit: length(axis.unit),
      points: table.rows.map((row, number) => ({ row: number, position: row[at] ?? 0, value: row[index] ?? 0 })),
      // Backlash is added to the values of the reverse column.
      offset: own && !column.forward ? axis.backlash : 0,
    };
  });
}
