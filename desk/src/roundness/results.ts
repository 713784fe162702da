// Zones, harmonics and spindle of evaluated readings.

import type { Desk } from "../core/desk";
import { el, section, table, type Cell } from "../core/dom";
import { cell, fixed } from "../core/number";
import { Plot, type Series } from "../core/plot";
import { CIRCLES, CIRCLE_WORDS, listed, type CircleName, type Roundness, type SpindleDirection, type Trace, type Zones } from "./documents";
import { themed } from "./picture";

/** Styles of LSC, MZC, MIC, MCC, as in the polar plot. */
const STYLES: Omit<Series, "name">[] = [{ colour: "after" }, { colour: "before", dash: [8, 3] }, { colour: "a", dash: [3, 3] }, { colour: "full", dash: [8, 3, 2, 3] }];

type Pick = (of: Roundness["per_revolution"][number]) => number;

export class Results {
  readonly tables = el("div", { class: "tables" });
  readonly root: HTMLElement;
  private readonly left_out = el("p", {});
  private readonly orbit = el("div", { class: "drawn" });
  private readonly profile: Plot;
  private readonly amplitudes: Plot;
  private readonly gains: Plot;
  private readonly motion: Plot;
  private readonly zones: Plot;
  private readonly departures: Plot;

  constructor(private readonly desk: Desk) {
    const [profile, amplitudes, gains] = [el("div"), el("div"), el("div")];
    const [motion, zones, departures] = [el("div"), el("div"), el("div")];
    const theta = "θ / °";
    const harmonic = "undulations per revolution";
    this.profile = new Plot(profile, { title: "Mean profile behind the filter", x: theta, y: "profile / µm", series: [{ name: "profile", colour: "measured" }], sync: "theta", height: 170 });
    this.amplitudes = new Plot(amplitudes, {
      title: "Amplitude of every harmonic, before the filter",
      x: harmonic,
      y: "amplitude / µm",
      series: [{ name: "amplitude", colour: "after", bars: "solid" }],
      sync: "harmonics",
    });
    this.gains = new Plot(gains, {
      title: "Noise gain of every harmonic",
      x: harmonic,
      y: "noise gain",
      logarithmic: true,
      series: [
        { name: "kept", colour: "servo", bars: "solid" },
        { name: "suppressed", colour: "warning", bars: "hatched" },
        { name: "limit", colour: "warning", dash: [6, 4] },
      ],
      sync: "harmonics",
    });
    const directions: Series[] = [
      { name: "X, across probe 1", colour: "x" },
      { name: "Y, along probe 1", colour: "y", dash: [7, 3] },
    ];
    this.motion = new Plot(motion, { title: "Error motion of the spindle, mean of the revolutions", x: theta, y: "error motion / µm", series: directions, sync: "theta", height: 260 });
    this.zones = new Plot(zones, {
      title: "Roundness of every revolution",
      x: "revolution",
      y: "zone / µm",
      series: STYLES.map((style, i) => ({ name: CIRCLES[i]!.toUpperCase(), ...style, dots: true })),
      sync: "revolutions",
    });
    this.departures = new Plot(departures, {
      title: "Largest distance of every revolution from the mean contour",
      x: "revolution",
      y: "distance / µm",
      series: directions.map((one) => ({ ...one, dots: true })),
      sync: "revolutions",
    });
    this.root = el(
      "div",
      {},
      section("Profile", profile),
      section("Harmonics", this.left_out, el("div", { class: "pair" }, amplitudes, gains)),
      section("Spindle", el("div", { class: "pair" }, el("figure", {}, this.orbit), el("div", {}, motion, zones, departures))),
    );
  }

  /** The document and, once the module has given them, the curves. */
  async show(found: Roundness, limit: number): Promise<void> {
    this.root.hidden = false;
    this.tables.replaceChildren(zoneTable(found), spindleTable(found));
    const [profile, x, y, orbit] = await Promise.all([
      this.desk.bench.call("roundness_curve", "profile"),
      this.desk.bench.call("roundness_curve", "x"),
      this.desk.bench.call("roundness_curve", "y"),
      this.desk.bench.call("roundness_orbit"),
    ]);
    const theta = Array.from(profile, (_, i) => (360 * i) / found.n);
    this.profile.set([theta, profile]);
    this.motion.set([theta, x, y]);
    this.orbit.innerHTML = themed(orbit);
    this.harmonics(found, limit);
    const revolutions = found.per_revolution.map((of) => of.revolution);
    const over = (pick: Pick) => found.per_revolution.map(pick);
    this.zones.set([revolutions, ...CIRCLES.map((name) => over((of) => of[`${name}_um`]))]);
    this.departures.set([revolutions, over((of) => of.x_from_mean_um), over((of) => of.y_from_mean_um)]);
  }

  private harmonics({ harmonics }: Roundness, limit: number): void {
    const k = harmonics.map((of) => of.k);
    const suppressed = harmonics.filter((of) => of.suppressed).map((of) => of.k);
    this.amplitudes.set([k, harmonics.map((of) => (of.suppressed ? null : of.amplitude_um))]);
    this.amplitudes.mark(suppressed.map((at, i) => ({ x: at, text: i === 0 ? `${at} suppressed` : "" })));
    const worst = Math.max(...harmonics.map((of) => of.noise_gain));
    // A limit far above the bars would flatten them.
    const drawn = limit < 30 * worst ? limit : null;
    this.gains.set([
      k,
      harmonics.map((of) => (of.suppressed ? null : of.noise_gain)),
      harmonics.map((of) => (of.suppressed ? of.noise_gain : null)),
      k.map(() => drawn),
    ]);
    const which = suppressed.length === 0 ? "None is suppressed" : `Suppressed: ${listed(suppressed)}`;
    this.left_out.textContent = `${which}; limit of the noise gain ${limit}${drawn === null ? ", above the figure" : ""}.`;
  }

  /** Circles of a trace, which has no harmonics and no spindle error. */
  showTrace(found: Trace): void {
    this.root.hidden = true;
    this.tables.replaceChildren(traceTable(found));
  }

  clear(): void {
    this.root.hidden = true;
    this.tables.replaceChildren();
  }
}

function zoneTable(found: Roundness): HTMLTableElement {
  const range = (key: keyof Zones) => {
    const values = found.per_revolution.map((of) => of[key]);
    return `${fixed(Math.min(...values), 3)} to ${fixed(Math.max(...values), 3)}`;
  };
  const row = (name: CircleName): Cell[] => {
    const [x, y] = found.centres_um[name];
    return [CIRCLE_WORDS[name], cell(found[`${name}_um`]), cell(x), cell(y), range(`${name}_um`)];
  };
  const filter = found.upr === null ? "no filter" : `filter ${found.upr} UPR`;
  return table(`Roundness of the mean of ${found.revolutions} revolutions, ${filter}`, ["circle", "zone / µm", "centre x / µm", "centre y / µm", "single revolutions / µm"], CIRCLES.map(row));
}

function spindleTable({ spindle }: Roundness): HTMLTableElement {
  const row = (name: string, of: SpindleDirection): Cell[] => [
    name,
    cell(of.synchronous_um),
    cell(of.asynchronous_um),
    cell(of.total_um),
    cell(of.once_per_revolution_um),
    cell(of.once_per_revolution_phase_deg, 1),
  ];
  const header = ["direction", "synchronous / µm", "asynchronous / µm", "total / µm", "once per revolution / µm", "its phase / °"];
  return table("Error motion of the spindle, ISO 230-7", header, [row("X, across probe 1", spindle.x), row("Y, along probe 1", spindle.y)]);
}

function traceTable(found: Trace): HTMLTableElement {
  const row = (name: CircleName): Cell[] => {
    const circle = found[name];
    if (!circle) return [CIRCLE_WORDS[name], `none: ${found.refused?.[name] ?? ""}`, "", "", ""];
    const [x, y] = circle.centre_mm;
    return [CIRCLE_WORDS[name], cell(circle.zone_um), cell(x, 6), cell(y, 6), cell(circle.radius_mm, 6)];
  };
  return table(`Reference circles of ${found.points} points, ISO 12181-1`, ["circle", "zone / µm", "centre x / mm", "centre y / mm", "radius / mm"], CIRCLES.map(row));
}
