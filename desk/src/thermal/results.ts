// Results of a warm-up: drift of held-out cycles, lags and curves.

import { el, section } from "../core/dom";
import { showPlots, showTables } from "../core/shown";
import type { Fitted } from "./documents";

export class Results {
  readonly root: HTMLElement;
  private readonly plots = el("div");
  private readonly figures = el("div", { class: "figures" });

  constructor() {
    this.root = el("div", { class: "columns" }, section("Held-out cycles", this.plots), section("Model", this.figures));
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
  }

  show({ shown }: Fitted): void {
    this.root.hidden = false;
    showPlots(this.plots, shown.plots);
    showTables(this.figures, shown);
  }
}
