// The record of the circles.

import { Plot } from "../core/plot";
import type { ColourName } from "../core/theme";
import type { Trace } from "./documents";

/** Following errors of a record. */
export function showTrace(host: HTMLElement, name: string, axes: readonly string[], trace: Trace): void {
  host.replaceChildren();
  const plot = new Plot(host, {
    title: `Following error of ${name}`,
    x: "time / s",
    y: "command − reading / µm",
    height: 200,
    series: axes.map((axis, i) => ({ name: axis, colour: axis.toLowerCase() as ColourName, ...(i > 0 ? { dash: [6, 3] } : {}), unit: "µm" })),
  });
  plot.set([trace.time_s, ...trace.following_error_um]);
}
