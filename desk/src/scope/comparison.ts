// A run kept as A, compared with the current run, B.

import { button, choice, el, section, table } from "../core/dom";
import { Plot } from "../core/plot";
import { KINDS, type Description, type Kind } from "./documents";
import type { Result } from "./results";
import { nearest, type Rows } from "./rows";
import { rapids, RAPID } from "./strip";
import { differences, type Setup } from "./setup";

export interface ComparedRun {
  setup: Setup;
  description: Description;
  result: Result;
  rows: Rows;
}

type Over = "length_mm" | "time_s";
const OVER: readonly (readonly [Over, string])[] = [
  ["length_mm", "length along the path / mm"],
  ["time_s", "time / s"],
];

export class Comparison {
  readonly root: HTMLElement;
  private readonly body = el("div", { class: "beside" });
  private readonly table = el("div");
  private readonly host = el("div");
  private readonly kind;
  private readonly over;
  private readonly drop: HTMLButtonElement;
  private readonly back: HTMLButtonElement;
  private plot: Plot | undefined;
  private now: ComparedRun | undefined;
  kept: ComparedRun | undefined;

  /** `current` returns the run to keep; `changed` is called when A changes; `settings` receives A's settings. */
  constructor(
    current: () => ComparedRun | undefined,
    private readonly changed: () => void,
    settings: (setup: Setup) => void,
  ) {
    const keep = button("Keep this run as A", () => this.keep(current()));
    this.drop = button("Drop A", () => this.keep(undefined), { disabled: true });
    this.back = button("Take A's settings", () => this.kept && settings(this.kept.setup), { disabled: true });
    this.kind = choice<Kind>("Machine", [["compensated", KINDS.compensated.text]], "compensated", () => this.draw());
    this.over = choice<Over>("Over", OVER, "length_mm", () => this.draw(true));
    this.body.append(el("div", { class: "row" }, this.kind.root, this.over.root), this.host, this.table);
    this.body.hidden = true;
    const hint = el("p", { class: "note" }, "Keep a run, change the settings, run again: the page shows both traces, both figures and the differences.");
    this.root = section("A beside B", el("div", { class: "row" }, keep, this.drop, this.back), hint, this.body);
  }

  /** Sets the run B. */
  set(now: ComparedRun): void {
    this.now = now;
    if (this.kept) this.draw();
  }

  private keep(kept: ComparedRun | undefined): void {
    this.kept = kept && { ...kept, setup: structuredClone(kept.setup) };
    this.body.hidden = this.drop.disabled = this.back.disabled = true;
    if (this.kept) {
      this.body.hidden = this.drop.disabled = this.back.disabled = false;
      const { kinds } = this.kept.description;
      this.kind.select.replaceChildren(...kinds.map((kind) => el("option", { value: kind }, KINDS[kind].text)));
      this.kind.value = kinds.includes("full") ? "full" : "compensated";
      this.draw(true);
    }
    this.changed();
  }

  private draw(rebuild = false): void {
    const { kept, now } = this;
    if (!kept || !now) return;
    const over = kept.rows.has(this.over.value) ? this.over.value : "time_s";
    if (rebuild || !this.plot) {
      this.host.replaceChildren();
      const x = OVER.find(([key]) => key === over)?.[1] ?? "";
      this.plot = new Plot(this.host, {
        title: "Contour error, A beside B",
        x,
        y: "error / µm",
        series: [{ name: "A", colour: "before", dash: [6, 3] }, { name: "B", colour: "after" }],
        height: 210,
        shaded: RAPID,
      });
    }
    const name = `${this.kind.value}.error_um`;
    // Over the longer run; at each position the nearest row of the other.
    const longer = (now.rows.column(over).at(-1) ?? 0) >= (kept.rows.column(over).at(-1) ?? 0) ? now : kept;
    const at = longer.rows.column(over);
    const curve = (of: ComparedRun) => {
      const values = of.rows.column(name);
      if (of === longer) return of.rows.curve(name);
      return Array.from(nearest(of.rows.column(over), at), (row) => (row < 0 || !Number.isFinite(values[row]) ? null : values[row]!));
    };
    this.plot.set([at, curve(kept), curve(now)]);
    this.plot.shade(rapids(longer.rows, at));
    const found = differences(kept.setup, now.setup);
    const rows = found.length > 0 ? found : [["nothing", "", ""]];
    this.table.replaceChildren(table("Differences", ["setting", "A", "B"], rows));
  }
}
