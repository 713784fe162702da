// The machine being edited: its files, the module's description of them, and its changes in their order.

import { redo, undo, type Desk } from "../core/desk";
import type { Change as Step, Files } from "../core/machine";
import type { Change, Shown } from "./document";

/** Changes of one gesture within this time are one undo step, ms. */
const GESTURE_MS = 1500;

export class Editor {
  shown: Shown | undefined;
  rate_hz = 10_000;
  /** Feed of all axes per minute; 0: the top feed of each. */
  feed_per_min = 0;
  private readonly listeners = new Set<() => void>();
  private readonly waiting = new Map<string, () => Promise<void>>();
  private last = { key: "", at: 0 };
  private json = "";
  private count = 0;
  private busy: Promise<void> | undefined;

  constructor(readonly desk: Desk) {
    desk.machine.subscribe(() => {
      if (desk.machine.json === this.json) return;
      // Another view, a link or a file has loaded another machine, or a change has been undone.
      this.last.key = "";
      void this.refresh();
    });
  }

  subscribe(listener: () => void): void {
    this.listeners.add(listener);
  }

  /** Whether nothing is queued, so that the module's latest response is current. */
  get settled(): boolean {
    return this.waiting.size === 0;
  }

  /** Evaluates the machine again after a change of rate or feed, or as it was loaded. */
  refresh(): Promise<void> {
    return this.queue("refresh", async () => {
      const json = this.desk.machine.json;
      const shown = await this.evaluate(json);
      this.json = json;
      this.shown = shown;
      this.notify();
    });
  }

  /** Makes a change. Of several changes with the same key only the last is queued; those with the key "" are all queued. A refused one changes nothing. */
  apply(change: Change, what: string, key: string): Promise<void> {
    return this.queue(key, async () => {
      const { machine, bench } = this.desk;
      const files = JSON.parse(await bench.call("machine_change", machine.json, JSON.stringify(change))) as Files;
      await this.take(machine.name, files, what, key);
    });
  }

  /** Replaces the machine by another one. */
  load(name: string, files: Files, what: string): Promise<void> {
    return this.queue("load", () => this.take(name, files, what, ""));
  }

  /** After the changes that are queued. */
  undo(): Promise<void> {
    return this.queue("", () => this.restore(this.desk.machine.undone, undo));
  }

  redo(): Promise<void> {
    return this.queue("", () => this.restore(this.desk.machine.redone, redo));
  }

  /** Evaluates the machine before it is set: a later evaluation would overwrite what is being typed. */
  private async restore(files: Files | undefined, step: (desk: Desk) => void): Promise<void> {
    if (!files) return;
    const json = JSON.stringify(files);
    const shown = await this.evaluate(json);
    [this.json, this.shown] = [json, shown];
    step(this.desk);
    this.last.key = "";
    this.notify();
  }

  private async take(name: string, files: Files, what: string, key: string): Promise<void> {
    const { machine } = this.desk;
    if (JSON.stringify(files) === machine.json && name === machine.name) {
      this.notify();
      return;
    }
    const now = performance.now();
    const joined = key !== "" && key === this.last.key && now - this.last.at < GESTURE_MS;
    await this.put(name, files, { what, joined });
    this.last = { key, at: performance.now() };
    this.notify();
    this.desk.note(what);
  }

  /** Makes the files the desk's machine, once the module has read them. */
  private async put(name: string, files: Files, step: Step): Promise<void> {
    const json = JSON.stringify(files);
    const shown = await this.evaluate(json);
    this.json = json;
    this.shown = shown;
    this.desk.machine.set(name, files, step);
  }

  private async evaluate(json: string): Promise<Shown> {
    const shown = await this.desk.bench.call("machine_show", json, this.rate_hz, this.feed_per_min);
    this.desk.clear();
    return JSON.parse(shown) as Shown;
  }

  private notify(): void {
    for (const listener of this.listeners) listener();
  }

  /** Runs tasks one after the other. */
  private queue(key: string, action: () => Promise<void>): Promise<void> {
    this.count += 1;
    const name = key === "" ? `once ${this.count}` : key;
    this.waiting.delete(name);
    this.waiting.set(name, action);
    this.busy ??= this.work().finally(() => (this.busy = undefined));
    return this.busy;
  }

  private async work(): Promise<void> {
    for (;;) {
      const next = this.waiting.entries().next();
      if (next.done) return;
      const [key, action] = next.value;
      this.waiting.delete(key);
      try {
        await action();
      } catch (error) {
        this.desk.fail(error);
        // Reset the controls to the valid values.
        this.notify();
      }
    }
  }
}
