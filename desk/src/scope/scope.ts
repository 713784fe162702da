// The view: what is set up, the run, and everything that shows it.

import "./scope.css";
import type { Desk } from "../core/desk";
import { el, section } from "../core/dom";
import { onDrop, picker, type Given } from "../core/files";
import type { Files } from "../core/machine";
import { Acts } from "./acts";
import { Bar } from "./bar";
import { Beside, type Kept } from "./beside";
import { Controls } from "./controls";
import { Curves, type Mark } from "./curves";
import type { BuiltIn, Description } from "./documents";
import { Exchanges } from "./exchanges";
import { Place } from "./place";
import { Programs, sort } from "./programs";
import { results } from "./results";
import { Runner, type Look } from "./runner";
import { exchangeOf, FIRST, fromState, request, type Setup } from "./setup";
import { Share } from "./share";
import { time } from "./times";

/** Between two pictures in three dimensions while a run goes on, ms. */
const PLACE_MS = 400;

export class Scope {
  private readonly runner: Runner;
  private readonly controls: Controls;
  private readonly bar: Bar;
  private readonly curves: Curves;
  private readonly place = new Place();
  private readonly acts: Acts;
  private readonly beside: Beside;
  private readonly share: Share;
  private readonly figures = el("div", { class: "figures" });
  private programs!: Programs;
  private description: Description | undefined;
  private look: Look | undefined;
  private cursor: number | null = null;
  private placed = 0;
  private readonly exchanges: Exchanges;
  /** The machine of the run. */
  private files: Files;
  /** The last request to open; those before it are stale. */
  private opening = 0;

  constructor(
    private readonly root: HTMLElement,
    private readonly desk: Desk,
  ) {
    this.files = desk.machine.files;
    this.exchanges = new Exchanges(desk.bench, desk.machine);
    this.runner = new Runner(desk.runs, (look) => this.looked(look), desk.fail);
    this.controls = new Controls(desk.bench, FIRST, () => this.changed("settings"));
    const act = <T>(of: Promise<T>) => void of.catch(desk.fail);
    this.bar = new Bar({
      run: (pace) => act(this.run(pace)),
      pause: () => act(this.runner.pause().then(() => this.refresh())),
      step: (cycles) => act(this.ready().then(() => this.runner.step(cycles))),
      restart: () => act(this.reopen()),
      pace: (pace) => (this.runner.pace = pace),
    });
    this.curves = new Curves((row) => this.moved(row));
    const opener = picker("Folder…", { folder: true }, (files) => this.taken(files), desk.fail);
    const host = {
      act: (what: string, after: string, at: number | undefined) => act(this.act(`${what}@${at === undefined ? "now" : `${at}s`}${after}`)),
      exchange: (source: string, at: number | undefined) => act(this.exchange(source, at)),
      remove: (gone: string) => this.remove(gone),
    };
    this.acts = new Acts(host, opener);
    this.beside = new Beside(() => this.kept(), () => this.refresh(), (setup) => this.take(structuredClone(setup)));
    this.share = new Share(desk, async () => {
      await this.ready();
      return this.runner.scenario();
    });
  }

  /** Builds the page and opens the first run. */
  async start(): Promise<void> {
    const { desk, root } = this;
    const builtIn = JSON.parse(await desk.bench.call("scope_programs")) as BuiltIn[];
    this.programs = new Programs(builtIn, (program) => this.take({ ...this.controls.setup, program }), (line) => this.toLine(line), (files) => this.taken(files), desk.fail);
    root.append(
      el(
        "div",
        { class: "three" },
        el("div", {}, this.programs.root, section("Settings", this.controls.root)),
        el("div", {}, section("Run", this.bar.root, this.curves.root), section("Acts in motion", this.acts.root), this.beside.root),
        el("div", {}, section("Place", this.place.root), section("Figures", this.figures), this.share.root),
      ),
    );
    onDrop(root, (files) => this.taken(files), desk.fail);
    desk.onProgram(async (program) => this.take({ ...this.controls.setup, program: { ...program } }));
    desk.machine.subscribe(() => {
      if (desk.machine.files === this.files) return;
      if (this.look?.progress.cycle) this.bar.changed("The machine has changed: Restart runs it, Exchange takes its tables.");
      else void this.reopen().catch(desk.fail);
    });
    desk.runs.onRestart(() => this.bar.changed("The run is lost: Run begins anew."));
    await this.reopen().catch(desk.fail);
  }

  state(): Setup & { machine?: Files } {
    const own = this.files === this.desk.machine.files ? {} : { machine: this.files };
    return { ...this.controls.setup, ...own };
  }

  /** Shows a kept state. */
  async show(state: unknown): Promise<void> {
    const { machine, ...setup } = state as Partial<Setup> & { machine?: Files };
    this.controls.set(fromState(setup));
    await this.reopen(machine ?? this.desk.machine.files);
  }

  /** Another setup: opened at once, for its program and errors to be seen. */
  private take(setup: Setup): void {
    const before = this.controls.setup;
    this.controls.set(setup);
    this.reopen().catch((error: unknown) => {
      this.controls.set(before);
      this.programs.set(before.program, this.description?.lines ?? []);
      this.desk.fail(error);
    });
  }

  private changed(what: string): void {
    if (this.look?.progress.cycle) this.bar.changed(`The ${what} have changed: Restart runs them.`);
    else void this.reopen().catch(this.desk.fail);
  }

  /** Opens the run of the present setup, at its beginning. */
  private async reopen(files: Files = this.desk.machine.files): Promise<void> {
    const ticket = ++this.opening;
    const { setup } = this.controls;
    await this.controls.machine(files);
    if (ticket !== this.opening) return;
    const { description, path } = await this.runner.open(request(setup, files));
    if (ticket !== this.opening) return;
    this.files = files;
    this.description = description;
    this.cursor = null;
    this.programs.set(setup.program, description.lines);
    this.curves.open(description);
    this.place.open(path, description.kinds);
    this.acts.open(description.axes.map(({ axis }) => axis));
    this.bar.changed("");
    this.desk.clear();
    this.desk.tell(description.notes.join("; "));
    this.refresh(true);
    this.share.set(await this.runner.scenario());
  }

  /** A run is open, after a restart of the module too. */
  private async ready(): Promise<void> {
    if (!this.runner.isOpen) await this.reopen(this.files);
  }

  private async run(pace: typeof this.runner.pace): Promise<void> {
    await this.ready();
    this.runner.pace = pace;
    this.runner.start();
    this.refresh();
  }

  private looked(look: Look): void {
    this.look = look;
    if (this.description) this.refresh();
  }

  /** Shows the run as it was last seen. */
  refresh(anew = false): void {
    const { look, description } = this;
    if (!look || !description) return;
    const { progress, figures, rows, rate } = look;
    const going = this.runner.isGoing;
    const { acts } = this.controls.setup;
    this.bar.set(progress, description, rate, going);
    this.acts.set(acts, progress.time_s);
    this.figures.replaceChildren(results({ progress, figures }, this.beside.kept?.result));
    if (this.root.hidden) return;
    const marks = acts.map((act): Mark => ({ x: time(act), text: act.split("@")[0] ?? "" })).filter(({ x }) => x <= progress.time_s);
    this.curves.set(rows, marks);
    const row = this.cursor ?? rows.count - 1;
    this.programs.listing.run(rows.at(row, "line") || 0);
    if (anew || !going || performance.now() - this.placed > PLACE_MS) {
      this.placed = performance.now();
      this.place.set(rows, row);
      const kept = this.kept();
      if (kept) this.beside.set(kept);
    }
  }

  private kept(): Kept | undefined {
    const { look, description } = this;
    return look && description && { setup: this.controls.setup, description, result: look, rows: look.rows };
  }

  /** The cursor of the plots stands at a row, or nowhere. */
  private moved(row: number | null): void {
    if (row === this.cursor || !this.look) return;
    this.cursor = row;
    const { rows } = this.look;
    const at = Math.min(rows.count - 1, row ?? rows.count - 1);
    this.programs.listing.run(rows.at(at, "line") || 0);
    this.place.show(at);
  }

  /** Brings cursor and place to a program line. */
  private toLine(line: number): void {
    const row = this.look?.rows.ofLine(line);
    if (row !== undefined) this.curves.show(row);
    else this.place.line(line);
  }

  private async act(text: string, files?: Files): Promise<void> {
    await this.ready();
    const { act } = await this.runner.act(text, files);
    const { setup } = this.controls;
    const name = exchangeOf(act);
    this.controls.setup = { ...setup, acts: [...setup.acts, act], exchanges: name && files ? { ...setup.exchanges, [name]: files } : setup.exchanges };
    this.refresh();
    this.share.set(await this.runner.scenario());
  }

  private async exchange(source: string, at: number | undefined): Promise<void> {
    const { name, files } = await this.exchanges.of(source, this.files, this.controls.setup.exchanges);
    await this.act(`exchange:${name}@${at === undefined ? "now" : `${at}s`}`, files);
  }

  private remove(gone: string): void {
    const { setup } = this.controls;
    this.controls.setup = { ...setup, acts: setup.acts.filter((act) => act !== gone) };
    this.changed("acts");
    this.refresh();
  }

  /** Takes files that were dropped or picked. */
  private taken(files: Given[]): void {
    const { desk } = this;
    try {
      const taken = sort(files);
      if ("program" in taken) this.take({ ...this.controls.setup, program: taken.program });
      else if ("settings" in taken) void this.controls.scenario(taken.settings, taken.file).catch(desk.fail);
      else {
        this.exchanges.give(taken.name, taken.machine);
        this.acts.offer(taken.name);
        desk.tell(`${taken.name}: tables to exchange for, in "Acts in motion".`);
      }
    } catch (error) {
      desk.fail(error);
    }
  }
}
