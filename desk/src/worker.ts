// Runs the module outside the page's thread, so that drawing and computing do not delay each other.

import * as module from "../pkg/trueaxis_desk";
import type { Answer } from "./core/bench";

interface Request {
  id: number;
  name: string;
  given: unknown[];
}

const post = postMessage as (answer: Answer, transfer?: Transferable[]) => void;
let ended = false;

Object.assign(globalThis, {
  /** Called by the module within a long call. */
  trueaxisProgress: (text: string) => post({ kind: "progress", text }),
  /** Called by the module's panic hook, before it traps. */
  trueaxisPanicked: (message: string) => {
    ended = true;
    post({ kind: "panicked", message });
  },
});

function answer({ id, name, given }: Request): void {
  const call = (module as unknown as Record<string, (...given: unknown[]) => unknown>)[name];
  if (typeof call !== "function") {
    post({ kind: "refused", id, message: `the module has no ${name}` });
    return;
  }
  try {
    const value = call(...given);
    post({ kind: "done", id, value }, ArrayBuffer.isView(value) ? [value.buffer] : []);
  } catch (error) {
    if (ended) return;
    // A trap without a preceding panic, such as exhausted memory or stack, also makes the module unusable.
    if (error instanceof WebAssembly.RuntimeError || error instanceof RangeError) {
      ended = true;
      post({ kind: "panicked", message: error.message });
    } else {
      post({ kind: "refused", id, message: error instanceof Error ? error.message : String(error) });
    }
  }
}

addEventListener("message", ({ data }: MessageEvent<Request | { module: WebAssembly.Module }>) => {
  if ("module" in data) {
    module.initSync({ module: data.module });
  } else if (!ended) {
    answer(data);
  }
});
