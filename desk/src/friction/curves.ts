// Spikes at the reversals and circles, side by side.

import { el } from "../core/dom";
import { fixed, significant } from "../core/number";
import { Plot } from "../core/plot";
import type { ColourName } from "../core/theme";
import type { CircleCurves, SpikeCurves, Trace } from "./documents";
import { Polar, keys, largest, type PolarSeries } from "../core/polar";

/** A curve of several stages, distinguished by colour and dashes. */
export interface Stage<T> {
  name: string;
  colour: ColourName;
  dash?: number[];
  of: T[];
  value: (curves: T) => number[];
}

/** Radii and feeds that differ by at most this share count as equal. */
const SAME = 0.05;
const same = (one: number, other: number) => Math.abs(one - other) <= SAME * Math.max(one, other);

/** The spike of the same axis with the nearest acceleration. Accelerations are estimates; those of other circles differ by a factor of 1.5. */
function alikeSpike(of: SpikeCurves[], { axis, acceleration_mm_per_s2 }: SpikeCurves): SpikeCurves | undefined {
  const ratio = (one: SpikeCurves) => Math.abs(Math.log(one.acceleration_mm_per_s2 / acceleration_mm_per_s2));
  const [nearest] = of.filter((one) => one.axis === axis).sort((one, other) => ratio(one) - ratio(other));
  return nearest && ratio(nearest) < Math.log(1.4) ? nearest : undefined;
}
const alikeCircle = (one: CircleCurves) => (other: CircleCurves) =>
  other.counterclockwise === one.counterclockwise && same(other.radius_mm, one.radius_mm) && same(other.feed_mm_per_min, one.feed_mm_per_min);

/** A legend that explains the dashes. */
function legend<T>(stages: Stage<T>[]): HTMLElement {
  return keys(stages.map(({ name, colour, dash }) => ({ name, colour, ...(dash ? { dash: dash.join(" ") } : {}) })));
}

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

/** One plot for each axis and size of circle; the first stage determines which. */
export function showSpikes(host: HTMLElement, stages: Stage<SpikeCurves>[]): void {
  const cells = el("div", { class: "grid" });
  host.replaceChildren(legend(stages), cells);
  for (const spike of stages[0]?.of ?? []) {
    const found = stages.map((stage) => ({ stage, curves: alikeSpike(stage.of, spike) })).filter(({ curves }) => curves);
    const place = el("div");
    cells.append(place);
    const plot = new Plot(place, {
      title: `Axis ${spike.axis}, ${significant(spike.acceleration_mm_per_s2, 3)} mm/s² at the reversal, mean of ${spike.reversals}`,
      x: "time after the reversal / ms",
      y: "deviation / µm",
      height: 190,
      digits: 3,
      series: found.map(({ stage: { name, colour, dash } }) => ({ name, colour, ...(dash ? { dash } : {}), unit: "µm" })),
    });
    const length = Math.min(...found.map(({ stage, curves }) => stage.value(curves!).length));
    plot.set([spike.time_ms.slice(0, length), ...found.map(({ stage, curves }) => stage.value(curves!).slice(0, length))]);
    plot.mark([{ x: 0, text: "reversal" }]);
  }
}

/** One polar plot for each circle, all of one scale. */
export function showCircles(host: HTMLElement, axes: readonly [string, string], stages: Stage<CircleCurves>[]): void {
  const cells = el("div", { class: "grid polars" });
  const [shown, all]: [[CircleCurves, PolarSeries[]][], PolarSeries[]] = [[], []];
  for (const circle of stages[0]?.of ?? []) {
    const series = stages.flatMap(({ name, colour, dash, of, value }): PolarSeries[] => {
      const curves = of.find(alikeCircle(circle));
      return curves ? [{ name, colour, ...(dash ? { dash: dash.join(" ") } : {}), angle_deg: curves.angle_deg, value_um: value(curves) }] : [];
    });
    shown.push([circle, series]);
    all.push(...series);
  }
  host.replaceChildren(legend(stages), cells);
  if (shown.length === 0) cells.append(el("p", {}, "The record holds no whole circle."));
  const most = largest(all);
  for (const [{ radius_mm, feed_mm_per_min, counterclockwise }, series] of shown) {
    const way = counterclockwise ? "counterclockwise" : "clockwise";
    new Polar(cells, `R ${significant(radius_mm, 4)} mm, ${fixed(feed_mm_per_min, 0)} mm/min, ${way}`, axes, series, most);
  }
}
