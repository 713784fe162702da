// Requests to the module, one after the other.

import type { Becomes } from "../core/becomes";
import type { Desk } from "../core/desk";
import { adopt } from "../core/machine";
import type { Shown } from "../core/shown-types";
import type { Found, RecordRead, Trace } from "./documents";
import { request, type Axes, type Circles } from "./source";

/** Cycles between two reports of progress. */
const SLICE = 20_000;
/** Points of a drawn record. */
const POINTS = 4000;

export class Stopped extends Error {}

export class Work {
  private stopping = false;

  constructor(private readonly desk: Desk) {}

  /** Ends the running simulation. */
  stop(): void {
    this.stopping = true;
  }

  async read(name: string, text: string, axes: Axes): Promise<[RecordRead, Trace]> {
    const read = JSON.parse(await this.desk.runs.call("friction_read", name, text, axes)) as RecordRead;
    return [read, await this.trace()];
  }

  private async trace(): Promise<Trace> {
    return JSON.parse(await this.desk.runs.call("friction_trace", POINTS)) as Trace;
  }

  /** Simulates one pass of the circles; `progress` gets the completed share. */
  async simulate(circles: Circles, pass: "record" | "before" | "after", progress: (share: number) => void): Promise<void> {
    const { runs, machine } = this.desk;
    this.stopping = false;
    await runs.call("friction_start", machine.json, request(circles, pass));
    for (let share = 0; share < 1; ) {
      if (this.stopping) throw new Stopped("stopped");
      share = await runs.call("friction_advance", SLICE);
      progress(share);
    }
  }

  async simulated(): Promise<[RecordRead, Trace]> {
    return [JSON.parse(await this.desk.runs.call("friction_record")) as RecordRead, await this.trace()];
  }

  csv(): Promise<string> {
    return this.desk.runs.call("friction_csv");
  }

  /** Identifies friction and drives; `progress` gets axis and step. */
  async fit(findDrive: boolean, progress: (text: string) => void): Promise<Found> {
    const { runs, machine } = this.desk;
    runs.onProgress = progress;
    try {
      return JSON.parse(await runs.call("friction_fit", machine.json, findDrive)) as Found;
    } finally {
      runs.onProgress = undefined;
    }
  }

  async closed(): Promise<Shown> {
    return JSON.parse(await this.desk.runs.call("friction_closed")) as Shown;
  }

  /** Writes the accepted figures into the machine that all views share; returns whether it changes, and the decisions. */
  async merge(): Promise<Becomes> {
    const { runs, machine } = this.desk;
    const becomes = JSON.parse(await runs.call("friction_becomes", machine.json)) as Becomes;
    if (becomes.changes) await adopt(this.desk, becomes.files, { what: "Friction found" });
    return becomes;
  }
}
