// Travel limits: the machine's, or typed ones.

import { choice, el, numberField } from "../core/dom";
import { AXES, type Fit, type Limits } from "./documents";

const TYPED: Limits = { X: [-400, 400], Y: [-400, 400], Z: [-400, 400], A: [-100, 100], C: [-36000, 36000] };

export class Travel {
  readonly root: HTMLElement;
  private readonly fields = el("div", { class: "triple" });
  private readonly said = el("p", { class: "said", role: "status" });
  private readonly source: { value: "machine" | "typed"; root: HTMLElement };
  typed: Limits = structuredClone(TYPED);

  constructor(private readonly changed: () => void) {
    this.source = choice("Travel limits", [["machine", "of the machine of the desk"], ["typed", "typed here"]] as const, "machine", () => this.reveal(true));
    this.root = el("div", { class: "limits" }, this.source.root, this.said, this.fields);
    this.build();
    this.reveal(false);
  }

  /** The state for a link. */
  state(): unknown {
    return { source: this.source.value, typed: this.typed };
  }

  open(state: { source?: "machine" | "typed"; typed?: Limits } | undefined): void {
    this.source.value = state?.source === "typed" ? "typed" : "machine";
    this.typed = { ...structuredClone(TYPED), ...state?.typed };
    this.build();
    this.reveal(false);
  }

  /** Limits in the module's format: an empty text requests the machine's. */
  asked(): string {
    return this.source.value === "machine" ? "" : JSON.stringify(this.typed);
  }

  /** The limits in force; a machine without A and C has none. */
  of(fit: Fit): Limits {
    if (this.source.value === "typed") return this.typed;
    this.said.textContent = fit.travel ? `Declared travel of ${fit.machine}.` : `${fit.machine} has no A and C axes, and therefore no limits. Type them, or take a machine with both.`;
    return fit.travel ?? {};
  }

  private reveal(notify: boolean): void {
    this.fields.hidden = this.source.value !== "typed";
    this.said.hidden = !this.fields.hidden;
    if (notify) this.changed();
  }

  private build(): void {
    const field = (letter: (typeof AXES)[number], end: 0 | 1) => {
      const unit = letter === "A" || letter === "C" ? "degrees" : "mm";
      return numberField({ label: `${letter} ${end === 0 ? "from" : "to"}`, unit, value: this.typed[letter]![end] }, (value) => {
        this.typed[letter]![end] = value;
        this.changed();
      }).root;
    };
    this.fields.replaceChildren(...AXES.flatMap((letter) => [field(letter, 0), field(letter, 1)]));
  }
}
