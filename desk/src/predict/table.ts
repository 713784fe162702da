// The characteristics as a table, each with a bar: deviation, interval and tolerance on one scale.

import { button, el } from "../core/dom";
import { cell, fixed, significant } from "../core/number";
import { titled, type Characteristic } from "./documents";
import { VERDICTS } from "./picture";

const HEAD = ["feature", "tolerance / µm", "uncorrected / µm", "corrected / µm", "everything on / µm", "± 95 % / µm", "tolerance used / %", "verdict", "deviation in its tolerance"];
/** Column of what only the servo has. */
const SERVO = 4;
/** Size of a bar, px, and the share of the scale beyond each end of the tolerance. */
const [WIDE, HIGH, BEYOND] = [170, 18, 0.3];

export class Features {
  readonly root = el("div", { class: "figures" });
  private readonly rows: Row[] = [];
  private readonly head = HEAD.map((name) => el("th", { scope: "col" }, name));

  constructor(private readonly choose: (index: number) => void) {}

  /** Keeps the rows if the characteristics are the same, so that the focus stays on its button. */
  set(features: readonly Characteristic[], used: readonly number[], chosen: number): void {
    const titles = features.map(titled);
    if (titles.join("\n") !== this.rows.map(({ title }) => title).join("\n")) this.build(titles);
    this.head[SERVO]!.hidden = features.every(({ everything_um }) => everything_um === undefined);
    for (const [k, of] of features.entries()) this.rows[k]!.set(of, used[k]!, k === chosen);
  }

  private build(titles: readonly string[]): void {
    this.rows.splice(0, Infinity, ...titles.map((title, k) => new Row(title, () => this.choose(k))));
    const head = el("tr", {}, ...this.head);
    const table = el("table", {}, el("caption", {}, "Characteristics"), el("thead", {}, head), el("tbody", {}, ...this.rows.map(({ root }) => root)));
    this.root.replaceChildren(table);
  }
}

class Row {
  readonly root: HTMLTableRowElement;
  private readonly open: HTMLButtonElement;
  private readonly cells = HEAD.slice(1, -1).map(() => el("td"));
  private readonly bar = el("td");

  constructor(
    readonly title: string,
    choose: () => void,
  ) {
    this.open = button(title, choose, { "aria-pressed": "false" });
    this.root = el("tr", {}, el("th", { scope: "row" }, this.open), ...this.cells, this.bar);
  }

  set(of: Characteristic, used: number, chosen: boolean): void {
    this.open.setAttribute("aria-pressed", String(chosen));
    const { colour, sign, text } = VERDICTS[of.verdict ?? "unknown"];
    const [least, most] = of.limits_um;
    const values = [
      [least, most].flatMap((um) => (um === null ? [] : [String(Number(um.toPrecision(6))).replace("-", "−")])).join(" to "),
      cell(of.uncorrected_um, 2),
      cell(of.corrected_um, 2),
      cell(of.everything_um, 2),
      cell(of.expanded_um, 2),
      cell(100 * used, 0),
      `${sign} ${text}`.trim(),
    ];
    this.cells[SERVO - 1]!.hidden = of.everything_um === undefined;
    for (const [k, value] of values.entries()) {
      const own = this.cells[k]!;
      own.textContent = typeof value === "string" ? value : value.text;
      own.className = typeof value === "string" ? "" : "number";
      if (typeof value === "string") delete own.dataset.value;
      else own.dataset.value = String(value.value);
    }
    this.bar.replaceChildren(bar(of, `var(--${colour})`));
  }
}

/** The tolerance as a box, the interval as a bar, the value that it belongs to as a line in it, the uncorrected one as a ring. */
function bar(of: Characteristic, colour: string): SVGElement {
  const [low, high] = [of.limits_um[0] ?? 0, of.limits_um[1] ?? 1];
  const room = BEYOND * (high - low);
  const x = (um: number) => fixed(Math.min(WIDE - 3, Math.max(3, (WIDE * (um - low + room)) / (high - low + 2 * room))), 1).replace("−", "-");
  const value = of.everything_um ?? of.corrected_um;
  const interval = of.interval_um ?? { low: value, high: value };
  const told = `${significant(value, 3)} µm${of.interval_um ? `, 95 % from ${significant(interval.low, 3)} to ${significant(interval.high, 3)} µm` : ""}, tolerance ${significant(low, 3)} to ${significant(high, 3)} µm`;
  const root = svg("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, width: WIDE, height: HIGH, role: "img", "aria-label": told });
  const width = (from: number, to: number) => Math.max(1.5, Number(x(to)) - Number(x(from)));
  root.append(
    svg("rect", { x: x(low), y: 1, width: width(low, high), height: HIGH - 2, fill: "var(--grid)", stroke: "var(--servo)" }),
    svg("rect", { x: x(interval.low), y: HIGH / 2 - 3, width: width(interval.low, interval.high), height: 6, fill: colour }),
    svg("line", { x1: x(value), x2: x(value), y1: 2, y2: HIGH - 2, stroke: "var(--ink)", "stroke-width": 1.5 }),
    svg("circle", { cx: x(of.uncorrected_um), cy: HIGH / 2, r: 3, fill: "none", stroke: "var(--ink)" }),
  );
  return root;
}

function svg(name: string, attributes: Record<string, string | number>): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  return element;
}
