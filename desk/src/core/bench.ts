// The module in a worker. Every export can be called by name; a panic ends the worker, and another is started.

import type * as Module from "../../pkg/trueaxis_desk";

type Exports = typeof Module;
type Calls = {
  [K in keyof Exports as Exports[K] extends (...arguments_: never[]) => unknown ? K : never]: Exports[K] extends (
    ...arguments_: never[]
  ) => unknown
    ? Exports[K]
    : never;
};
export type CallName = Exclude<keyof Calls, "default" | "initSync" | "start">;

/** Answers of the worker. */
export type Answer =
  | { kind: "done"; id: number; value: unknown }
  | { kind: "refused"; id: number; message: string }
  | { kind: "progress"; text: string }
  | { kind: "panicked"; message: string };

interface Waiting {
  done: (value: never) => void;
  failed: (error: Error) => void;
}

/** The module panicked: calls in progress are lost, and the worker has been restarted. */
export class Restarted extends Error {}

export class Bench {
  /** Started while the module is still being unpacked. */
  private worker: Worker;
  private readonly waiting = new Map<number, Waiting>();
  /** Receives the progress of a long call. */
  onProgress: ((text: string) => void) | undefined;
  private readonly restarts = new Set<(message: string) => void>();
  private next = 0;

  constructor(
    private readonly module: Promise<WebAssembly.Module>,
    private readonly script: string,
  ) {
    this.worker = this.start();
  }

  /** Calls an export of the module. */
  call<K extends CallName>(name: K, ...given: Parameters<Calls[K]>): Promise<ReturnType<Calls[K]>> {
    const { worker } = this;
    const id = this.next++;
    return new Promise((done, failed) => {
      this.waiting.set(id, { done, failed });
      void this.module.then(() => worker.postMessage({ id, name, given }), failed);
    });
  }

  /** Calls the listener after each restart, with the module's message. */
  onRestart(listener: (message: string) => void): void {
    this.restarts.add(listener);
  }

  private start(): Worker {
    const url = URL.createObjectURL(new Blob([this.script], { type: "text/javascript" }));
    const worker = new Worker(url);
    worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => {
      if (data.kind === "progress") this.onProgress?.(data.text);
      else if (data.kind === "panicked") this.restart(data.message);
      else this.answer(data);
    });
    // Failures that no panic reports, such as running out of memory.
    worker.addEventListener("error", (event) => {
      event.preventDefault();
      this.restart(event.message || "the worker ended");
    });
    // The worker expects the module as its first message, before any call.
    void this.module.then((module) => worker.postMessage({ module }), () => undefined);
    return worker;
  }

  private answer(answer: Extract<Answer, { id: number }>): void {
    const waiting = this.waiting.get(answer.id);
    this.waiting.delete(answer.id);
    if (answer.kind === "done") waiting?.done(answer.value as never);
    else waiting?.failed(new Error(answer.message));
  }

  /** Ends the worker; calls in progress fail with this error. */
  close(why: Error): void {
    this.worker.terminate();
    const lost = [...this.waiting.values()];
    this.waiting.clear();
    for (const { failed } of lost) failed(why);
  }

  private restart(message: string): void {
    this.close(new Restarted(message));
    this.worker = this.start();
    for (const listener of this.restarts) listener(message);
  }
}
