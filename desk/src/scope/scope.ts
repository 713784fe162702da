// The view's run: opened from the setup, acted on, and exported.

import "./scope.css";
import type { Desk } from "../core/desk";
import { onDrop, picker, type Given } from "../core/files";
import type { Files } from "../core/machine";
import { Controls } from "./controls";
import type { BuiltIn } from "./documents";
import { Exchanges } from "./exchanges";
import { sort } from "./programs";
import { Runner, type Pace, type Snapshot } from "./runner";
import { Screen } from "./screen";
import { exchangeOf, FIRST, fromState, request, type Setup } from "./setup";
import { Share } from "./share";

/** Names of the tables before and after a measured correction, and the share of the run after which they are exchanged. */
const [BEFORE, CORRECTED] = ["before", "corrected"];
const CORRECTED_AT = 0.25;

/** Whether the reader wants no motion. */
const isStill = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Scope {
  private readonly runner: Runner;
  private readonly controls: Controls;
  private readonly screen: Screen;
  private readonly share: Share;
  private readonly exchanges: Exchanges;
  private snapshot: Snapshot | undefined;
  /** The machine of the run. */
  private files: Files;
  /** The last request to open; those before it are stale. */
  private opening = 0;
  /**
   * Whether the opening run shows itself: it goes on while the view is visible, and changed settings restart it at once. It ends
   * with the user's first command to a run.
   */
  private demonstrates = false;
  private queue: Promise<void> = Promise.resolve();

  constructor(
    private readonly root: HTMLElement,
    private readonly desk: Desk,
  ) {
    this.files = desk.machine.files;
    this.exchanges = new Exchanges(desk.bench, desk.machine);
    this.runner = new Runner(desk.runs, (snapshot) => this.updated(snapshot), desk.fail);
    this.controls = new Controls(desk.bench, FIRST, () => this.changed("settings"));
    this.share = new Share(desk, () => this.ready().then(() => this.runner.scenario()));
    const guard = <T>(of: Promise<T>) => void of.catch(desk.fail);
    const own = <Given extends unknown[]>(command: (...given: Given) => void) => (...given: Given) => {
      this.demonstrates = false;
      command(...given);
    };
    const when = (at: number | undefined) => (at === undefined ? "now" : `${at}s`);
    const taken = (files: Given[]) => this.taken(files);
    this.screen = new Screen(
      root,
      {
        run: own((pace) => guard(this.run(pace))),
        pause: own(() => guard(this.runner.pause().then(() => this.refresh()))),
        step: own((cycles) => guard(this.ready().then(() => this.runner.step(cycles)))),
        restart: own(() => guard(this.reopen())),
        pace: (pace) => (this.runner.pace = pace),
        act: (what, after, at) => guard(this.act(`${what}@${when(at)}${after}`)),
        exchange: (source, at) => guard(this.exchange(source, when(at))),
        remove: (act) => this.remove(act),
        program: (program) => this.take({ ...this.controls.setup, program }),
        taken,
        failed: desk.fail,
        warm: () => this.controls.change("temperature_c", this.controls.reference_temperature_c + 6),
        unplug: () => guard(this.act("dropout:X@now+500")),
        halve: () => guard(this.exchange("half", "now")),
        settings: (setup) => this.take(structuredClone(setup)),
      },
      { controls: this.controls.root, opener: picker("Folder…", { folder: true }, taken, desk.fail), share: this.share.root },
    );
    onDrop(root, taken, desk.fail);
  }

  /** Opens the first run, and follows machine and module. */
  async start(): Promise<void> {
    const { desk } = this;
    const builtIn = desk.bench.call("scope_programs").then((listed) => this.screen.programs.builtIn(JSON.parse(listed) as BuiltIn[]));
    desk.onProgram(async ({ name, text }) => this.take({ ...this.controls.setup, program: { name, text } }));
    desk.machine.subscribe(() => {
      if (desk.machine.files === this.files) return;
      // Whoever puts a correction into the machine wants to see it.
      if (desk.machine.before) this.demonstrates = !isStill();
      else this.withoutCorrection();
      if (this.demonstrates || desk.machine.before) void this.demonstrate().catch(desk.fail);
      else if (this.snapshot?.progress.cycle) this.screen.bar.changed("The machine has changed: Restart runs it, Exchange takes its tables.");
      else void this.reopen().catch(desk.fail);
    });
    desk.runs.onRestart(() => this.screen.bar.changed("The run is lost: Run starts it again."));
    this.demonstrates = !isStill();
    if (this.demonstrates) this.screen.bar.pace = "real";
    await Promise.all([this.demonstrate().catch(desk.fail), builtIn]);
  }

  /**
   * Opens the run and lets it go on while it is visible. After a measured correction the simulated machine has the errors found:
   * it runs with the tables from before, and in motion it gets the corrected ones.
   */
  private async demonstrate(): Promise<void> {
    const { before, files } = this.desk.machine;
    this.withoutCorrection();
    if (before) {
      const { setup } = this.controls;
      this.controls.setup = { ...setup, acts: [...setup.acts, `exchange:${BEFORE}@0s`], exchanges: { ...setup.exchanges, [BEFORE]: before } };
    }
    await this.reopen();
    const { description } = this.screen;
    if (before && description && files === this.files) await this.act(`exchange:${CORRECTED}@${(CORRECTED_AT * description.cycles * description.period_s).toFixed(1)}s`, files);
    await this.goOn();
  }

  /** Removes the exchanges that show a correction. */
  private withoutCorrection(): void {
    const { setup } = this.controls;
    const acts = setup.acts.filter((act) => ![BEFORE, CORRECTED].includes(exchangeOf(act) ?? ""));
    const { [BEFORE]: _before, [CORRECTED]: _corrected, ...exchanges } = setup.exchanges;
    this.controls.setup = { ...setup, acts, exchanges };
  }

  private async goOn(): Promise<void> {
    await this.ready();
    if (!this.demonstrates || this.root.hidden) return;
    this.runner.pace = this.screen.bar.pace;
    this.runner.start();
    this.refresh();
  }

  /** The view comes to the front, or leaves it. */
  visible(visible: boolean): void {
    if (visible) this.refresh(true);
    if (!this.demonstrates || !this.runner.isOpen) return;
    const turned = visible ? this.goOn() : this.runner.pause();
    void turned.catch(this.desk.fail);
  }

  state(): Setup & { machine?: Files } {
    const own = this.files === this.desk.machine.files ? {} : { machine: this.files };
    return { ...this.controls.setup, ...own };
  }

  /** Shows a kept state. */
  async show(state: unknown): Promise<void> {
    const { machine, ...setup } = state as Partial<Setup> & { machine?: Files };
    this.demonstrates = false;
    this.controls.set(fromState(setup));
    await this.reopen(machine ?? this.desk.machine.files);
  }

  /** Shows the run as it was last seen. */
  refresh(redraw = false): void {
    if (this.snapshot) this.screen.show(this.snapshot, this.controls.setup, this.runner.isGoing, redraw);
  }

  /** Sets another setup: opened at once, to show its program and errors. */
  private take(setup: Setup): void {
    this.demonstrates = false;
    const before = this.controls.setup;
    this.controls.set(setup);
    this.reopen().catch((error: unknown) => {
      this.controls.set(before);
      this.screen.programs.set(before.program, this.screen.description?.lines ?? []);
      this.desk.fail(error);
    });
  }

  private changed(what: string): void {
    if (this.demonstrates) void this.demonstrate().catch(this.desk.fail);
    else if (this.snapshot?.progress.cycle) this.screen.bar.changed(`The ${what} have changed: Restart runs them.`);
    else void this.reopen().catch(this.desk.fail);
  }

  /** Opens the run of the present setup at its beginning. Requests wait for one another; stale ones are skipped. */
  private reopen(files?: Files): Promise<void> {
    const ticket = ++this.opening;
    const isCurrent = () => ticket === this.opening;
    const next = this.queue.catch(() => undefined).then(() => (isCurrent() ? this.opened(files ?? this.desk.machine.files, isCurrent) : undefined));
    this.queue = next;
    return next;
  }

  private async opened(files: Files, isCurrent: () => boolean): Promise<void> {
    const { setup } = this.controls;
    const [{ description, path }] = await Promise.all([this.runner.open(request(setup, files)), this.controls.machine(files)]);
    if (!isCurrent()) return;
    this.files = files;
    this.screen.open(description, path, setup);
    this.desk.clear();
    this.desk.note(description.notes.join("; "));
    this.refresh(true);
    this.share.set(await this.runner.scenario());
  }

  /** Ensures that a run is open, also after a restart of the module. */
  private async ready(): Promise<void> {
    await this.queue.catch(() => undefined);
    if (!this.runner.isOpen) await this.reopen(this.files);
  }

  private async run(pace: Pace): Promise<void> {
    await this.ready();
    this.runner.pace = pace;
    this.runner.start();
    this.refresh();
  }

  private updated(snapshot: Snapshot): void {
    this.snapshot = snapshot;
    this.refresh();
    // For the test of the time from loading to the first motion.
    if (snapshot.progress.cycle > 0) document.documentElement.dataset.motionMs ??= String(Math.round(performance.now()));
  }

  private async act(text: string, files?: Files): Promise<void> {
    await this.ready();
    const { act } = await this.runner.act(text, files);
    const { setup } = this.controls;
    const name = exchangeOf(act);
    const exchanges = name && files ? { ...setup.exchanges, [name]: files } : setup.exchanges;
    this.controls.setup = { ...setup, acts: [...setup.acts, act], exchanges };
    this.refresh();
    this.share.set(await this.runner.scenario());
  }

  private async exchange(source: string, when: string): Promise<void> {
    const { name, files } = await this.exchanges.of(source, this.files, this.controls.setup.exchanges);
    await this.act(`exchange:${name}@${when}`, files);
  }

  private remove(removed: string): void {
    const { setup } = this.controls;
    this.controls.setup = { ...setup, acts: setup.acts.filter((act) => act !== removed) };
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
      else void this.given(taken.machine).catch(desk.fail);
    } catch (error) {
      desk.fail(error);
    }
  }

  private async given(files: readonly Given[]): Promise<void> {
    const name = await this.exchanges.give(files);
    this.screen.acts.offer(name);
    this.desk.note(`${name}: its tables can be exchanged in "Acts in motion".`);
  }
}
