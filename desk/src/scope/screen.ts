// All displays of a run, with one cursor for traces, program and position.

import { el, section } from "../core/dom";
import { Acts, type ActsHost } from "./acts";
import { Bar, type BarHost } from "./bar";
import { Comparison, type ComparedRun } from "./comparison";
import { Curves, type Mark } from "./curves";
import type { Description } from "./documents";
import { Place } from "./place";
import { Programs, type ProgramsHost } from "./programs";
import { Sentence } from "../core/shown";
import { Intro, type IntroHost } from "./intro";
import { exchanged, results, sentence } from "./results";
import type { Snapshot } from "./runner";
import type { Setup } from "./setup";
import { time } from "./times";
import { actInWords } from "./words";

/** Time between two three-dimensional pictures, and between two tables of figures, during a run, ms. */
const PLACE_MS = 400;

/** Requests from the screen. */
export interface ScreenHost extends ActsHost, BarHost, ProgramsHost, IntroHost {
  settings(setup: Setup): void;
}

export class Screen {
  readonly bar: Bar;
  readonly acts: Acts;
  readonly programs: Programs;
  readonly intro: Intro;
  private readonly curves: Curves;
  private readonly place = new Place();
  private readonly comparison: Comparison;
  private readonly sentence = new Sentence();
  private readonly exchange = new Sentence();
  private readonly figures = el("div", { class: "figures" });
  private cursor: number | null = null;
  private placed = 0;
  private shown: ComparedRun | undefined;
  description: Description | undefined;

  constructor(
    private readonly root: HTMLElement,
    host: ScreenHost,
    parts: { controls: HTMLElement; opener: HTMLElement; share: HTMLElement },
  ) {
    this.bar = new Bar(host);
    this.intro = new Intro(host);
    this.acts = new Acts(host, parts.opener);
    this.programs = new Programs(host, (line) => this.toLine(line));
    this.curves = new Curves((row) => this.moved(row));
    this.comparison = new Comparison(
      () => this.shown,
      () => this.results(),
      (setup) => host.settings(setup),
    );
    root.append(
      el(
        "div",
        { class: "parts" },
        el("div", { class: "run" }, section("Run", this.bar.root, this.intro.root, this.sentence.root, this.exchange.root, this.curves.root)),
        el("div", { class: "side" }, section("Place", this.place.root), section("Acts in motion", this.acts.root)),
        el("div", { class: "setup-of" }, this.programs.root, section("Settings", parts.controls)),
        el("div", { class: "more" }, section("Figures", this.figures), this.comparison.root, parts.share),
      ),
    );
  }

  /** Sets another run, at its start. */
  open(description: Description, path: Float32Array, setup: Setup): void {
    this.description = description;
    this.cursor = null;
    this.programs.set(setup.program, description.lines);
    this.curves.open(description);
    this.place.open(path, description.kinds);
    this.acts.open(description.axes.map(({ axis }) => axis));
    this.bar.changed("");
  }

  /** Shows the latest state of the run; `redraw`: draws everything at once. */
  show(snapshot: Snapshot, setup: Setup, going: boolean, redraw = false): void {
    const { description } = this;
    if (!description) return;
    const { progress, rows, rate } = snapshot;
    this.shown = { setup, description, result: snapshot, rows };
    this.bar.set(progress, description, rate, going);
    this.acts.set(setup.acts, progress.time_s);
    const all = redraw || !going || performance.now() - this.placed > PLACE_MS;
    if (all) this.results();
    if (this.root.hidden) return;
    const marks = setup.acts.map((act): Mark => ({ x: time(act), text: actInWords(act) })).filter(({ x }) => x <= progress.time_s);
    this.curves.set(rows, marks);
    const row = Math.min(this.cursor ?? Infinity, rows.count - 1);
    this.programs.listing.run(rows.at(row, "line") || 0);
    if (all) {
      this.placed = performance.now();
      this.place.set(rows, row);
      this.comparison.set(this.shown);
    }
  }

  private results(): void {
    if (!this.shown) return;
    this.sentence.set(sentence(this.shown.result));
    this.exchange.set(exchanged(this.shown.rows, this.shown.setup.acts, this.shown.result.progress.done));
    this.figures.replaceChildren(results(this.shown.result, this.comparison.kept?.result));
  }

  /** Sets the row of the plots' cursor, or none. */
  private moved(row: number | null): void {
    const rows = this.shown?.rows;
    if (row === this.cursor || !rows) return;
    this.cursor = row;
    const at = Math.min(rows.count - 1, row ?? rows.count - 1);
    this.programs.listing.run(rows.at(at, "line") || 0);
    this.place.show(at);
  }

  /** Moves cursor and position to a program line. */
  private toLine(line: number): void {
    const row = this.shown?.rows.ofLine(line);
    if (row !== undefined) this.curves.show(row);
    else this.place.line(line);
  }
}
