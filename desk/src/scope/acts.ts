// Acts on a run in motion: faults, other tables, switches; and the list of them.

import { button, choice, el, group, numberField, type Field } from "../core/dom";
import { fixed } from "../core/number";
import { time } from "./times";
import { actInWords, injected, SWITCHES } from "./words";

/** A fault as requested. */
interface FaultKind {
  axis: boolean;
  /** Name and initial value of its parameter; the unit follows the axis. */
  value?: { label: string; first: number; plain?: boolean };
  cycles: number;
}

const FAULTS: Record<string, FaultKind> = {
  dropout: { axis: true, cycles: 3 },
  glitch: { axis: true, value: { label: "By", first: 5 }, cycles: 1 },
  stuck: { axis: true, cycles: 500 },
  scale: { axis: true, value: { label: "Times", first: -1, plain: true }, cycles: 20000 },
  late: { axis: false, value: { label: "Periods", first: 2.5, plain: true }, cycles: 1 },
  "nan-command": { axis: true, cycles: 1 },
  "jump-command": { axis: true, value: { label: "By", first: 3 }, cycles: 1 },
};

/** Whether a switch is on before the first act on it. */
const isOnAtFirst = (name: string): boolean => name !== "trial";

export interface ActsHost {
  /** Injects a fault or switches a part; `what` and `after` are the specification before and after the time. */
  act(what: string, after: string, at: number | undefined): void;
  /** Exchanges the run's tables for half of them, those of the page's machine, or those of an opened machine. */
  exchange(source: string, at: number | undefined): void;
  remove(act: string): void;
}

export class Acts {
  readonly root: HTMLElement;
  private readonly when: HTMLInputElement;
  private readonly axis;
  private readonly value: Field;
  private readonly source;
  private readonly switches = new Map<string, HTMLButtonElement>();
  private readonly list: HTMLElement;

  constructor(
    private readonly host: ActsHost,
    opener: HTMLElement,
  ) {
    this.when = el("input", { id: "scope-when", type: "number", min: 0, step: "any", placeholder: "now" });
    const when = el("div", { class: "field" }, el("label", { for: "scope-when" }, "Acts at / s (empty: now)"), this.when);
    const kinds = Object.keys(FAULTS).map((key) => [key, injected(key)] as const);
    const cycles = numberField({ label: "For / cycles", value: FAULTS.dropout!.cycles, min: 1, step: 1 }, () => {});
    const kind = choice("Fault", kinds, "dropout", (key) => this.kind(key, cycles));
    this.axis = choice("Axis", [["X", "X"], ["Y", "Y"], ["Z", "Z"]], "X", () => this.kind(kind.value, cycles, true));
    this.value = numberField({ label: "By", value: 5 }, () => {});
    const inject = button("Inject", () => {
      const { axis, value } = FAULTS[kind.value]!;
      const amount = value ? `=${this.value.value}${value.plain ? "" : this.unit()}` : "";
      this.host.act(`${kind.value}${axis ? `:${this.axis.value}` : ""}`, `+${cycles.value}${amount}`, this.at());
    });
    this.source = choice("Tables of", [["half", "this machine, all errors halved"], ["edited", "the machine view as it is now"]], "half", () => {});
    const exchange = button("Exchange", () => this.host.exchange(this.source.value, this.at()));
    const switches = SWITCHES.map(([name, text]) => {
      const one = button(text, () => this.host.act(`${one.getAttribute("aria-pressed") === "true" ? "off" : "on"}:${name}`, "", this.at()), { "aria-pressed": String(isOnAtFirst(name)) });
      this.switches.set(name, one);
      return one;
    });
    this.list = el("div", { class: "rows" });
    this.root = el(
      "div",
      { class: "acts" },
      el("div", { class: "row" }, when, group("Fault", kind.root, this.axis.root, cycles.root, this.value.root, inject), group("Exchange tables", this.source.root, exchange, opener), group("Switch, pressed is on", ...switches)),
      this.list,
    );
    this.kind("dropout", cycles);
  }

  /** Sets another run: its axes. */
  open(axes: readonly string[]): void {
    const now = this.axis.value;
    this.axis.select.replaceChildren(...axes.map((axis) => el("option", { value: axis }, axis)));
    if (axes.includes(now)) this.axis.value = now;
  }

  /** Adds a machine whose tables can be exchanged. */
  offer(name: string): void {
    if (![...this.source.select.options].some((option) => option.value === `given:${name}`)) this.source.select.append(el("option", { value: `given:${name}` }, name));
    this.source.select.value = `given:${name}`;
  }

  /** The acts of the run, and which of them have begun. */
  set(acts: readonly string[], now_s: number): void {
    const timed = acts.map((act) => ({ act, at: time(act) })).sort((one, other) => one.at - other.at);
    for (const [name, pressed] of this.switches) {
      const last = timed.filter(({ act, at }) => at <= now_s && new RegExp(`^(on|off):${name}@`).test(act)).at(-1);
      pressed.setAttribute("aria-pressed", String(last ? !last.act.startsWith("off") : isOnAtFirst(name)));
    }
    const key = JSON.stringify([acts, timed.map(({ at }) => at <= now_s)]);
    if (this.list.dataset.key === key) return;
    this.list.dataset.key = key;
    const head = el("tr", {}, ...["time / s", "act", "in a scenario", "", ""].map((name) => el("th", { scope: "col" }, name)));
    const rows = timed.map(({ act, at }) =>
      el("tr", {}, el("td", { class: "number" }, fixed(at, 4)), el("td", {}, actInWords(act)), el("td", {}, el("code", {}, act)), el("td", {}, at <= now_s ? "done" : "pending"), el("td", {}, button("Remove", () => this.host.remove(act), { "aria-label": `Remove ${act}` }))),
    );
    const none = el("tr", {}, el("td", { colspan: 5 }, "none yet: every act here is part of the scenario and is repeated after Restart"));
    this.list.replaceChildren(el("table", {}, el("caption", {}, "Acts in motion"), el("thead", {}, head), el("tbody", {}, ...(rows.length > 0 ? rows : [none]))));
  }

  private at(): number | undefined {
    return this.when.value.trim() === "" ? undefined : this.when.valueAsNumber;
  }

  private unit(): string {
    return "ABC".includes(this.axis.value) ? "deg" : "mm";
  }

  /** Shows the inputs that a kind of fault needs. */
  private kind(key: string, cycles: Field, keep = false): void {
    const { axis, value, cycles: count } = FAULTS[key]!;
    this.axis.select.disabled = !axis;
    this.value.root.hidden = !value;
    if (value) {
      this.value.root.querySelector("label")!.textContent = value.plain ? value.label : `${value.label} / ${this.unit()}`;
      if (!keep) this.value.value = value.first;
    }
    if (!keep) cycles.value = count;
  }
}
