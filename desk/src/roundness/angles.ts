// Manually adjusted probe angles, their noise gain, and the best pairs.

import { message, type Desk } from "../core/desk";
import { button, commandLine, el, numberField, section } from "../core/dom";
import { significant } from "../core/number";
import { Plot } from "../core/plot";
import { tabled } from "../core/shown";
import { listed, probeOptions, type Best, type Curve, type Probes } from "./documents";
import { arrangement } from "./picture";
import { ProbeControls } from "./probes";

export class Angles {
  readonly root: HTMLElement;
  readonly controls: ProbeControls;
  private readonly picture = el("div", { class: "picture" });
  private readonly said = el("p", { role: "status", class: "gain" });
  private readonly plot: Plot;
  private readonly progress = el("progress", { max: 1, value: 0, hidden: true, "aria-label": "Search of the best pairs" });
  private readonly found = el("div");
  private readonly command = commandLine("The same on the command line:");
  private readonly count;
  private readonly start: HTMLButtonElement;
  private busy = false;
  private waiting = false;
  private search = 0;

  constructor(
    private readonly desk: Desk,
    probes: Probes,
    use: (probes: Probes) => void,
    readings: () => Probes,
  ) {
    this.controls = new ProbeControls("Probes moved by hand", probes, () => this.moved());
    const place = el("div");
    this.plot = new Plot(place, {
      title: "Noise gain of these angles",
      x: "undulations per revolution",
      y: "noise gain",
      logarithmic: true,
      series: [{ name: "noise gain", colour: "servo", bars: "solid" }],
      height: 220,
    });
    this.count = numberField({ label: "Pairs to list", value: 20, min: 1, max: 10_000, step: 1 }, () => this.say());
    this.start = button("Find the best pairs", () => void this.run());
    const take = button("Take those of the readings", () => this.set(readings()));
    const give = button("Use for the readings", () => use(this.controls.value));
    this.root = section(
      "Probe angles",
      el("div", { class: "beside" }, this.picture, el("div", {}, this.controls.root, this.said, el("div", { class: "row" }, take, give))),
      place,
      el("div", { class: "row" }, this.count.root, this.start, this.progress),
      el("p", { class: "said" }, "The search looks at all pairs of slots: at once up to N = 1024, about a second for 4096, longer with a wide band. It can be stopped."),
      this.found,
      this.command.root,
    );
    this.moved();
  }

  get value(): { probes: Probes; count: number } {
    return { probes: this.controls.value, count: this.count.value };
  }

  set value({ probes, count }: { probes: Probes; count: number }) {
    this.count.value = count;
    this.set(probes);
  }

  set(probes: Probes): void {
    this.controls.value = probes;
    this.moved();
  }

  /** Sends one request at a time; the last position of a slider is always evaluated. */
  private moved(): void {
    this.say();
    this.waiting = true;
    if (this.busy) return;
    this.busy = true;
    const work = async () => {
      while (this.waiting) {
        this.waiting = false;
        await this.show();
      }
    };
    void work().finally(() => (this.busy = false));
  }

  private async show(): Promise<void> {
    const probes = this.controls.value;
    try {
      const curve = JSON.parse(await this.desk.bench.call("probe_angles_curve", JSON.stringify(probes))) as Curve;
      this.picture.replaceChildren(arrangement(curve.phi2_deg, curve.phi3_deg));
      this.plot.set([curve.noise_gains.map((of) => of.k), curve.noise_gains.map((of) => of.noise_gain)]);
      this.plot.mark(curve.worst ? [{ x: curve.worst.worst_harmonic, text: `worst: ${curve.worst.worst_harmonic}` }] : curve.blind.map((k) => ({ x: k, text: `${k} blind` })));
      this.said.replaceChildren(...words(curve));
    } catch (error) {
      this.said.replaceChildren(el("span", { class: "warning" }, message(error)));
      this.plot.set([[], []]);
    }
  }

  private say(): void {
    this.command.set(["trueaxis probe-angles", ...probeOptions(this.controls.value), "--count", this.count.value, "--json"].join(" "));
  }

  /** The search runs in slices, so that it can be stopped. */
  private async run(): Promise<void> {
    this.search += 1;
    if (!this.progress.hidden) {
      this.finished("The search was stopped.");
      return;
    }
    const mine = this.search;
    this.start.textContent = "Stop";
    this.progress.hidden = false;
    this.progress.value = 0;
    const { probes, count } = this.value;
    try {
      await this.desk.runs.call("probe_angles_open", JSON.stringify({ probes, count }));
      let steps = 1;
      while (this.progress.value < 1) {
        const begun = performance.now();
        const share = await this.desk.runs.call("probe_angles_advance", steps);
        if (mine !== this.search) return;
        this.progress.value = share;
        const took = performance.now() - begun;
        if (took < 60) steps *= 2;
        else if (took > 250) steps = Math.max(1, steps >> 1);
      }
      this.list(JSON.parse(await this.desk.runs.call("probe_angles_finish")) as Best);
      this.finished(`${count} best pairs of ${probes.n} slots found.`);
    } catch (error) {
      if (mine === this.search) this.finished("");
      this.desk.fail(error);
    }
  }

  private finished(said: string): void {
    this.progress.hidden = true;
    this.start.textContent = "Find the best pairs";
    this.desk.note(said);
  }

  private list({ best, table }: Best): void {
    const listing = tabled(table);
    listing.querySelector("thead tr")?.append(el("th", { scope: "col" }, "show"));
    listing.querySelectorAll("tbody tr").forEach((line, i) => {
      const { p, q } = best[i] ?? {};
      const { n, harmonics } = this.controls.value;
      const show = () => this.set({ n, ...(harmonics ? { harmonics } : {}), p: p!, q: q! });
      line.append(el("td", {}, p === undefined ? null : button("Show", show, { "aria-label": `Show pair ${i + 1}` })));
    });
    this.found.replaceChildren(el("div", { class: "rows", tabindex: 0, role: "group", "aria-label": "Best pairs" }, listing));
  }
}

function words({ worst, blind, singular }: Curve): (Node | string)[] {
  const beyond = singular.filter((k) => !blind.includes(k));
  const outside = beyond.length > 0 ? ` Outside the band these angles cannot see harmonics ${listed(beyond)}.` : "";
  if (!worst) return [el("strong", { class: "warning" }, `These angles cannot see harmonics ${listed(blind)} of the band.`), outside];
  const gain = el("strong", { "data-value": String(worst.worst_noise_gain) }, significant(worst.worst_noise_gain, 4));
  const at = el("strong", { "data-value": String(worst.worst_harmonic) }, String(worst.worst_harmonic));
  return ["Worst noise gain ", gain, " at harmonic ", at, ": there the noise of the probes grows that many times.", outside];
}
