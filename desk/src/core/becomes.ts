// Measured values that become machine settings, and the button that applies them.

import type { Desk } from "./desk";
import { button, el, notes, section, table, type Cell } from "./dom";
import { adopt, type Files } from "./machine";
import { asFarAs, significant } from "./number";

/** A setting that changes. */
interface Setting {
  key: string;
  before: number;
  after: number;
  /** Standard uncertainty stated for it. */
  uncertainty: number | null;
}

/** The machine with the results, as the module returns it. */
export interface Becomes {
  files: Files;
  settings: Setting[];
  changes: boolean;
  notes: string[];
  /** The machine that was measured, if it is not the one shown. */
  own?: { name: string; files: Files };
}

/** Half of the interval that contains a normally distributed value with 95 %, in standard uncertainties. */
const EXPANDED = 1.959963984540054;
/** Settings named on the button. */
const NAMED = 2;

/** Value before, value after and expanded uncertainty, rounded to the uncertainty's second digit. */
function figures({ before, after, uncertainty }: Setting): [before: Cell, after: Cell, expanded: Cell] {
  const half = uncertainty === null ? NaN : EXPANDED * uncertainty;
  const rounded = (value: number): Cell => ({ text: asFarAs(value, half), value });
  return [rounded(before), rounded(after), uncertainty === null ? "–" : { text: significant(half, 2), value: half }];
}

/** `C0Y 38.0 → 49.6 ± 1.2 µrad`, `backlash X 6.00 → 11.01 ± 0.13 µm`. */
function inWords(setting: Setting): string {
  const [, axis, key = "", unit = ""] = /^(?:axis\.(\w)|location)\.(\w+)_(um|urad|mm|deg)$/.exec(setting.key) ?? [];
  const [before, after, expanded] = figures(setting).map((cell) => (typeof cell === "string" ? "" : cell.text));
  const name = key === "" ? setting.key : [key, axis].filter(Boolean).join(" ");
  return `${name} ${before} → ${after}${expanded ? ` ± ${expanded}` : ""} ${{ um: "µm", urad: "µrad", deg: "°" }[unit] ?? unit}`.trim();
}

export class IntoMachine {
  readonly root: HTMLElement;
  private readonly place = el("div", { class: "figures" });
  private readonly status = el("span", { role: "status", class: "said" });
  private readonly put: HTMLButtonElement;
  private readonly words = el("small");
  private readonly run: HTMLButtonElement;
  private becomes: Becomes | undefined;
  private taken = false;
  /** The results last put into a machine, and its files before and after. */
  private last: { becomes: Becomes; before: string; after: string } | undefined;
  /** Called once a machine has the results. */
  whenDone: () => void = () => {};
  /** Called once they have been undone. */
  whenUndone: () => void = () => {};

  /** `controls` are placed before the table. */
  constructor(
    private readonly desk: Desk,
    private readonly what: string,
    ...controls: HTMLElement[]
  ) {
    this.put = button("Put into the machine", () => void this.take().catch(desk.fail), { class: "primary put", disabled: true });
    this.put.append(this.words);
    this.run = button("Run the corrected machine", () => void desk.show("scope"), { hidden: true });
    this.root = section("Into the machine", ...controls, this.place, el("div", { class: "row" }, this.put, this.run, this.status));
    desk.machine.subscribe(() => this.follow());
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
    this.run.hidden = true;
    this.words.textContent = "";
    this.place.replaceChildren();
    if (!becomes) return;
    const { settings } = becomes;
    const more = settings.length > NAMED ? [`${settings.length - NAMED} more`] : [];
    this.words.textContent = [...settings.slice(0, NAMED).map(inWords), ...more].join("; ");
    const rows = settings.map((setting): Cell[] => [setting.key, ...figures(setting)]);
    this.place.append(
      rows.length > 0 ? table("Settings that change", ["key of machine.toml", "before", "after", `± 95 %, k = ${EXPANDED.toFixed(2)}`], rows) : el("p", {}, "No setting changes."),
      notes("Decisions", becomes.notes),
    );
  }

  private async take(): Promise<void> {
    const { becomes } = this;
    const { machine, note } = this.desk;
    if (!becomes) return;
    const { files, own } = becomes;
    this.show(undefined);
    this.taken = true;
    this.last = { becomes, before: own ? JSON.stringify(own.files) : machine.json, after: JSON.stringify(files) };
    try {
      await adopt(this.desk, files, { what: this.what, measured: true, own: own?.files }, own?.name);
    } catch (error) {
      this.taken = false;
      throw error;
    }
    note(`${this.what} put into ${machine.name}: every view uses it now. Undo, above, takes it back; Save machine exports it.`);
    this.has();
    this.whenDone();
  }

  private has(): void {
    this.taken = true;
    this.status.textContent = `In ${this.desk.machine.name} now.`;
    this.run.hidden = false;
  }

  /** Follows undo and redo of the results. */
  private follow(): void {
    const { last, desk } = this;
    if (!last) return;
    if (this.taken && desk.machine.json === last.before) {
      this.taken = false;
      this.show(last.becomes);
      this.whenUndone();
    } else if (!this.taken && desk.machine.json === last.after) {
      this.show(undefined);
      this.has();
      this.whenDone();
    }
  }
}
