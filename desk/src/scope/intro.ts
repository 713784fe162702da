// What the opening run shows, and what to try on it.

import { button, el } from "../core/dom";

export interface IntroHost {
  /** Warms the surroundings of the machine. */
  warm(): void;
  /** Takes the reading of an encoder away for a moment. */
  unplug(): void;
  /** Exchanges the tables of the run. */
  halve(): void;
}

export class Intro {
  readonly root: HTMLElement;

  constructor(host: IntroHost) {
    this.root = el(
      "div",
      { class: "intro", role: "note", "aria-label": "What is seen, and what to try" },
      el("p", {}, "A simulated mill cuts the program below: the traces show how far the tool tip is from its path. Try:"),
      el("div", { class: "row" }, button("Warm it by 6 K", () => host.warm()), button("Pull an encoder's plug", () => host.unplug()), button("Exchange its tables", () => host.halve())),
    );
  }
}
