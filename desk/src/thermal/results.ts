// Results of a warm-up: drift of held-out cycles, lags and curves.

import { el, section } from "../core/dom";
import { heldOut } from "../core/sentence";
import { Sentence, showPlots, showTables } from "../core/shown";
import type { Fitted } from "./documents";

export class Results {
  readonly root: HTMLElement;
  private readonly sentence = new Sentence();
  private readonly plots = el("div");
  private readonly figures = el("div", { class: "figures" });

  constructor() {
    this.root = el("div", {}, this.sentence.root, el("div", { class: "columns" }, section("Held-out cycles", this.plots), section("Model", this.figures)));
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show({ shown }: Fitted): void {
    this.root.hidden = false;
    this.sentence.set(heldOut(shown));
    showPlots(this.plots, shown.plots);
    showTables(this.figures, shown);
  }
}
