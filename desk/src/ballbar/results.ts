// Figures, causes and curves of a circular test.

import { el, section } from "../core/dom";
import { largestShare } from "../core/sentence";
import { Sentence, showPolars, showTables } from "../core/shown";
import type { Evaluated } from "./documents";

export class Results {
  readonly root: HTMLElement;
  private readonly sentence = new Sentence();
  private readonly curves = el("div");
  private readonly figures = el("div", { class: "figures" });

  constructor() {
    this.root = el("div", {}, this.sentence.root, el("div", { class: "columns" }, section("Deviation of the radius", this.curves), section("Figures and causes", this.figures)));
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show({ shown }: Evaluated): void {
    this.root.hidden = false;
    this.sentence.set(largestShare(shown, "the deviation", "correct it first"));
    showPolars(this.curves, shown.polars);
    showTables(this.figures, shown);
  }
}
