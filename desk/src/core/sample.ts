// Sample records: opened with one click, and marked while they are shown.

import { button, el } from "./dom";

export class Samples {
  readonly root: HTMLElement;
  private readonly mark = el("strong", { class: "sample", hidden: true });

  /** `entries`: the text of the button, and the action that opens the sample. */
  constructor(entries: readonly (readonly [text: string, open: () => void])[], ...more: HTMLElement[]) {
    this.root = el("div", { class: "row samples" }, ...entries.map(([text, open]) => button(text, open)), ...more, this.mark);
  }

  /** Marks what is shown as a sample, or as the user's record. */
  set shown(shown: boolean) {
    this.say(shown ? "Sample" : "");
  }

  /** Marks what is shown as something else than the user's record. */
  say(what: string): void {
    this.mark.hidden = what === "";
    this.mark.textContent = what && `${what}, not your record`;
  }
}

/** The machine with which the desk starts: samples are opened unasked only on this one. */
export const FIRST_MACHINE = "mill-3axis";
