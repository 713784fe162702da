// Zones, harmonics and spindle of evaluated readings.

import type { Desk } from "../core/desk";
import { el, section } from "../core/dom";
import { Plot, type Series } from "../core/plot";
import { showPlots, tabled } from "../core/shown";
import type { Shown } from "../core/shown-types";
import { listed, type Roundness } from "./documents";
import { themed } from "./picture";

export class Results {
  readonly tables = el("div", { class: "tables" });
  readonly root: HTMLElement;
  private readonly left_out = el("p", {});
  private readonly orbit = el("div", { class: "drawn" });
  private readonly profile: Plot;
  private readonly amplitudes: Plot;
  private readonly gains: Plot;
  private readonly motion: Plot;
  private readonly development = el("div");

  constructor(private readonly desk: Desk) {
    const [profile, amplitudes, gains] = [el("div"), el("div"), el("div")];
    const motion = el("div");
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
    this.root = el(
      "div",
      {},
      section("Profile", profile),
      section("Harmonics", this.left_out, el("div", { class: "pair" }, amplitudes, gains)),
      section("Spindle", el("div", { class: "pair" }, el("figure", {}, this.orbit), el("div", {}, motion, this.development))),
    );
  }

  /** The document and, once the module has given them, the curves. */
  async show(found: Roundness, { tables, plots }: Shown, limit: number): Promise<void> {
    this.root.hidden = false;
    this.tables.replaceChildren(...tables.map(tabled));
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
    showPlots(this.development, plots);
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
  showTrace({ tables }: Shown): void {
    this.root.hidden = true;
    this.tables.replaceChildren(...tables.map(tabled));
  }

  clear(): void {
    this.root.hidden = true;
    this.tables.replaceChildren();
  }
}
