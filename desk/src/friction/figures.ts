// The identified figures in tables.

import { el, table, type Cell } from "../core/dom";
import { shown } from "../core/number";
import type { AxisFound, Closed, Found, Size } from "./documents";

type Key = keyof AxisFound["friction"] | Exclude<keyof AxisFound["drive"], "dead_time_s">;

const FIGURES: ReadonlyArray<readonly [Key, string]> = [
  ["coulomb_mm_per_s", "Coulomb friction F_c/K_vp / mm/s"],
  ["presliding_um", "pre-sliding z / µm"],
  ["stribeck_share", "Stribeck share s"],
  ["stribeck_velocity_mm_per_s", "Stribeck velocity v_s / mm/s"],
  ["viscous", "viscous friction d/K_vp"],
  ["position_gain_per_s", "position gain K_v / 1/s"],
  ["velocity_gain_per_s", "velocity gain K_vp / 1/s"],
  ["reset_time_s", "reset time τ / s"],
  ["velocity_feed_forward", "velocity feed-forward k_ff"],
];

const value = (own: AxisFound, key: Key): number => (key in own.friction ? own.friction[key as keyof AxisFound["friction"]] : own.drive[key as keyof AxisFound["drive"]]);

const sizes = (size: Size): Cell[] => [shown(size.max, 3), shown(size.rms, 3)];

/** Figures with standard errors, the fit, the spikes, the fixed figures. */
export function showFound(host: HTMLElement, { document: { axes, warnings } }: Found): void {
  const names = axes.flatMap(({ axis }) => [axis, `± ${axis}`]);
  const figures = FIGURES.map(([key, name]): Cell[] => [
    name,
    ...axes.flatMap((own): Cell[] => {
      const error = own.standard_errors[key];
      const held = key in own.friction || own.drive_found ? "held" : "the machine's";
      return [shown(value(own, key), 4), error === null ? held : shown(error, 2)];
    }),
  ]);
  const fit = axes.map((own): Cell[] => [
    own.axis,
    { text: String(own.reversals), value: own.reversals },
    { text: String(own.fitted), value: own.fitted },
    shown(own.residual_um, 3),
    shown(100 * own.explained, 4),
    shown(own.condition, 3),
  ]);
  const spikes = axes.flatMap(({ axis, glitch_um: { before, predicted, after } }): Cell[][] => [
    [`${axis} before, recorded`, ...sizes(before)],
    [`${axis} predicted by the model`, ...sizes(predicted)],
    [`${axis} after, expected`, ...sizes(after)],
  ]);
  host.replaceChildren(
    table("Figures found, with standard errors", ["figure", ...names], figures),
    table("Spikes at the reversals", ["spikes", "largest / µm", "RMS / µm"], spikes),
    table("Fit", ["axis", "reversals", "parameters", "residual / µm", "explained / %", "condition number"], fit),
    ...(warnings.length === 0 ? [] : [el("ul", { class: "notes", "aria-label": "Notes" }, ...warnings.map((text) => el("li", {}, text)))]),
  );
}

const AGAIN = ["spikes", "largest / µm", "RMS / µm"] as const;

/** The circles without and with the figures, as simulated. */
export function showClosed(host: HTMLElement, { outcome }: Closed): void {
  if (!outcome) {
    host.replaceChildren();
    return;
  }
  const spikes = outcome.axes.flatMap(({ axis, glitch_um: { before, expected, after } }): Cell[][] => [
    [`${axis} before`, ...sizes(before)],
    [`${axis} expected after`, ...sizes(expected)],
    [`${axis} after`, ...sizes(after)],
  ]);
  const error = outcome.contour_error_um;
  const truth = FIGURES.map(([key, name]): Cell[] => [
    name,
    ...outcome.axes.flatMap(({ identified, true: plant }): Cell[] => [shown(identified[key], 4), shown(plant[key], 4)]),
  ]);
  const names = outcome.axes.flatMap(({ axis }) => [`${axis} found`, `${axis} true`]);
  host.replaceChildren(
    table("Spikes, simulated again", AGAIN, spikes),
    table("Contour error of the tip, geometry included", ["pass", "largest / µm", "RMS / µm"], [
      ["before", ...sizes(error.before)],
      ["after", ...sizes(error.after)],
    ]),
    table("Found against the simulated drives", ["figure", ...names], truth),
  );
}
