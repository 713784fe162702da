// Measured values that become machine settings, and the button that applies them.

import type { Desk } from "./desk";
import { button, el, notes, section, table, type Cell } from "./dom";
import { adopt, type Files } from "./machine";
import { shown } from "./number";

/** The machine with the results, as the module returns it. */
export interface Becomes {
  files: Files;
  settings: { key: string; before: number; after: number; uncertainty: number | null }[];
  changes: boolean;
  notes: string[];
  /** Name of the machine, if it is not the one shown. */
  name?: string;
}

export class IntoMachine {
  readonly root: HTMLElement;
  private readonly place = el("div", { class: "figures" });
  private readonly status = el("span", { role: "status", class: "said" });
  private readonly put: HTMLButtonElement;
  private becomes: Becomes | undefined;
  private taken = false;
  /** Called once a machine has the results. */
  whenDone: () => void = () => {};

  /** `controls` are placed before the table. */
  constructor(
    private readonly desk: Desk,
    private readonly what: string,
    ...controls: HTMLElement[]
  ) {
    this.put = button("Put into the machine", () => void this.take().catch(desk.fail), { class: "primary", disabled: true });
    this.root = section("Into the machine", ...controls, this.place, el("div", { class: "row" }, this.put, this.status));
  }

  /** Whether a machine has the results. */
  get done(): boolean {
    return this.taken;
  }

  /** Begins another measurement, whose results no machine has yet. */
  begin(): void {
    this.taken = false;
    this.show(undefined);
  }

  /** Shows the changes to the machine, or the reason why it has none. Offers no results that the machine already has: it would get them twice. */
  show(becomes: Becomes | undefined, why = ""): void {
    if (this.taken) return;
    this.becomes = becomes;
    this.status.textContent = why;
    this.put.disabled = !becomes?.changes;
    this.place.replaceChildren();
    if (!becomes) return;
    const rows = becomes.settings.map(({ key, before, after, uncertainty }): Cell[] => [key, shown(before, 4), shown(after, 4), uncertainty === null ? "" : shown(uncertainty, 4)]);
    this.place.append(
      rows.length > 0 ? table("Settings that change", ["key of machine.toml", "before", "after", "standard uncertainty"], rows) : el("p", {}, "No setting changes."),
      notes("Decisions", becomes.notes),
    );
  }

  private async take(): Promise<void> {
    const { machine, note } = this.desk;
    if (!this.becomes) return;
    const { files, name } = this.becomes;
    this.show(undefined);
    this.taken = true;
    try {
      await adopt(this.desk, files, name);
    } catch (error) {
      this.taken = false;
      throw error;
    }
    note(`${this.what} put into ${machine.name}: every view uses it now. Export it in the view Machine.`);
    this.status.textContent = `In ${machine.name} now.`;
    this.whenDone();
  }
}
