// Start time of an act.

/** When an act begins, s. */
export function time(act: string): number {
  return Number(/@([^@]*?)s(\+|$)/.exec(act)?.[1] ?? NaN);
}
