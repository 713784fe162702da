// Temperatures while the part is cut: the machine's thermal.toml, and a record with the start of the program in it.

import { button, el, textField } from "../core/dom";
import type { Request } from "./documents";

export class Temperature {
  readonly root: HTMLElement;
  private readonly said = el("p");
  private readonly begin;

  /** `start` gets the text of the field; `leave` is called to leave the files out. */
  constructor(start: (text: string) => void, leave: () => void) {
    this.begin = textField("Start of the program / s after the first row, or HH:MM", "0", () => start(this.begin.input.value));
    this.root = el("div", { class: "row", hidden: true }, this.said, this.begin.root, button("Leave out", leave));
  }

  set({ thermal, record, start }: Pick<Request, "thermal" | "record" | "start">): void {
    const told = [thermal ? `Growth by ${thermal[0]}.` : [], record ? `Temperatures of ${record[0]}.` : []].flat();
    this.root.hidden = told.length === 0;
    this.said.textContent = told.join(" ");
    this.begin.root.hidden = !record;
    // Not while it is typed in.
    if (this.begin.input.value !== (start ?? "")) this.begin.input.value = start ?? "";
  }
}
