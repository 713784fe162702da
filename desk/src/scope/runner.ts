// A run in the worker for long tasks, in slices, so that the page draws and responds in between.

import { Restarted, type Bench } from "../core/bench";
import type { Files } from "../core/machine";
import type { Description, Figures, Progress, Recorded, Scenario } from "./documents";
import { Rows } from "./rows";

/** Duration of a slice, ms: the longest wait of an act in motion. */
const SLICE_MS = 40;
/** Time between two updates of the traces, ms: the least, and the most if drawing is slow. */
const UPDATE_MS = 110;
const LONGEST_UPDATE_MS = 1500;
/** Updates are at least this many drawing times apart, so that a slow computer draws less often and still responds. */
const REST = 6;
/** Two frames of a screen that has nothing to draw, ms. */
const TWO_FRAMES_MS = 34;
/** Cycles of a run's first slice, short so that it moves at once. */
const FIRST_SLICE = 100;
const MOST_CYCLES = 50_000;

export type Pace = "fast" | "real" | "slow";
/** Simulated seconds per second of the clock. */
const SPEED: Record<Exclude<Pace, "fast">, number> = { real: 1, slow: 0.1 };

export interface Snapshot {
  progress: Progress;
  figures: Figures;
  rows: Rows;
  /** Cycles per second while running. */
  rate: number;
}

export interface Opened {
  description: Description;
  path: Float32Array;
}

export class Runner {
  private handle: number | undefined;
  private columns: string[] = [];
  private progress: Progress = { cycle: 0, cycles: 0, time_s: 0, done: false };
  private going = false;
  private loop: Promise<void> = Promise.resolve();
  private slice = FIRST_SLICE;
  private spent_ms = 0;
  private spent_cycles = 0;
  private period_s = 1e-4;
  private rest_ms = UPDATE_MS;
  pace: Pace = "fast";

  constructor(
    private readonly runs: Bench,
    private readonly updated: (snapshot: Snapshot) => void,
    private readonly failed: (error: unknown) => void,
  ) {
    runs.onRestart(() => this.lost());
  }

  get isOpen(): boolean {
    return this.handle !== undefined;
  }

  get isGoing(): boolean {
    return this.going;
  }

  /** Opens a run in place of the previous one, which stays if the new one is refused. */
  async open(request: string): Promise<Opened> {
    await this.pause();
    const handle = await this.runs.call("scope_open", request);
    await this.close();
    this.handle = handle;
    [this.slice, this.spent_ms, this.spent_cycles] = [FIRST_SLICE, 0, 0];
    const description = JSON.parse(await this.runs.call("scope_describe", handle)) as Description;
    this.columns = await this.runs.call("scope_columns", handle);
    this.period_s = description.period_s;
    this.progress = { cycle: 0, cycles: description.cycles, time_s: 0, done: false };
    const path = await this.runs.call("scope_path", handle);
    await this.update();
    return { description, path };
  }

  /** Continues until the end or a pause. */
  start(): void {
    if (this.going || this.handle === undefined) return;
    this.going = true;
    this.loop = this.run().catch((error: unknown) => {
      this.going = false;
      if (!(error instanceof Restarted)) this.failed(error);
    });
  }

  /** Ends the running slice. */
  async pause(): Promise<void> {
    this.going = false;
    await this.loop;
  }

  /** Runs this many cycles. */
  async step(cycles: number): Promise<void> {
    await this.pause();
    if (this.handle === undefined) return;
    await this.advance(this.handle, cycles);
    await this.update();
  }

  private async advance(handle: number, cycles: number): Promise<void> {
    this.progress = JSON.parse(await this.runs.call("scope_advance", handle, cycles)) as Progress;
  }

  /** An act in motion, at the next cycle if its time is `now`; in the form of the scenario. */
  async act(act: string, files?: Files): Promise<Recorded> {
    if (this.handle === undefined) throw new Error("found no run, needed one that is open");
    return JSON.parse(await this.runs.call("scope_act", this.handle, JSON.stringify({ act, files }))) as Recorded;
  }

  async scenario(): Promise<Scenario> {
    if (this.handle === undefined) throw new Error("found no run, needed one that is open");
    return JSON.parse(await this.runs.call("scope_scenario", this.handle)) as Scenario;
  }

  private async run(): Promise<void> {
    let last = -Infinity;
    while (this.going && this.handle !== undefined) {
      const began = performance.now();
      const from = this.progress.cycle;
      const paced = this.pace === "fast" ? this.slice : Math.max(1, Math.round((SPEED[this.pace] * SLICE_MS) / 1e3 / this.period_s));
      const cycles = from === 0 ? Math.min(FIRST_SLICE, paced) : paced;
      await this.advance(this.handle, cycles);
      const took = performance.now() - began;
      this.spent_ms += took;
      this.spent_cycles += this.progress.cycle - from;
      if (this.pace === "fast") this.slice = Math.min(MOST_CYCLES, Math.max(50, Math.round((cycles * SLICE_MS) / Math.max(1, took))));
      else if (took < SLICE_MS) await new Promise((done) => setTimeout(done, SLICE_MS - took));
      if (this.progress.done) this.going = false;
      if (this.progress.done || performance.now() - last > this.rest_ms) {
        await this.update();
        last = performance.now();
      }
    }
    if (this.handle !== undefined) await this.update();
  }

  private async update(): Promise<void> {
    const { handle } = this;
    if (handle === undefined) return;
    const figures = JSON.parse(await this.runs.call("scope_figures", handle)) as Figures;
    const rows = new Rows(this.columns, await this.runs.call("scope_traces", handle));
    this.measure();
    this.updated({ progress: this.progress, figures, rows, rate: this.spent_ms > 0 ? (1e3 * this.spent_cycles) / this.spent_ms : 0 });
  }

  /** Measures the page's drawing time, which sets the time between updates. */
  private measure(): void {
    const began = performance.now();
    const drawn = () => {
      const spent = performance.now() - began - TWO_FRAMES_MS;
      this.rest_ms = Math.min(LONGEST_UPDATE_MS, Math.max(UPDATE_MS, REST * spent));
    };
    requestAnimationFrame(() => requestAnimationFrame(drawn));
  }

  private async close(): Promise<void> {
    const { handle } = this;
    this.handle = undefined;
    if (handle !== undefined) await this.runs.call("scope_close", handle);
  }

  /** The module was restarted: its runs are gone. */
  private lost(): void {
    this.going = false;
    this.handle = undefined;
  }
}
