// The polar plot with its four circles, each of which can be hidden.

import type { Desk } from "../core/desk";
import { el, group, tick } from "../core/dom";
import { CIRCLES, CIRCLE_WORDS, type CircleName } from "./documents";
import { themed } from "./picture";

export class Polar {
  readonly root = el("div", { class: "drawn" });
  readonly ticks: HTMLElement;
  private readonly shown: Record<CircleName, boolean> = { lsc: true, mzc: true, mic: true, mcc: true };
  private readonly boxes;

  constructor(
    private readonly desk: Desk,
    refresh: () => Promise<void>,
  ) {
    this.boxes = CIRCLES.map((name) =>
      tick(CIRCLE_WORDS[name], true, (checked) => {
        this.shown[name] = checked;
        refresh().then(() => this.draw()).catch(desk.fail);
      }),
    );
    this.ticks = group("Reference circles", ...this.boxes.map((box) => box.root));
  }

  get hidden(): CircleName[] {
    return CIRCLES.filter((name) => !this.shown[name]);
  }

  set hidden(names: CircleName[]) {
    CIRCLES.forEach((name, i) => {
      this.shown[name] = !names.includes(name);
      this.boxes[i]!.input.checked = this.shown[name];
    });
  }

  /** The latest result. */
  async draw(): Promise<void> {
    const { lsc, mzc, mic, mcc } = this.shown;
    this.root.innerHTML = themed(await this.desk.bench.call("roundness_polar", lsc, mzc, mic, mcc));
  }

  clear(): void {
    this.root.replaceChildren();
  }
}
