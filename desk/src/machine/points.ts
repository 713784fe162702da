// Table values as input fields; rows can be added and removed.

import { button, el, numberField } from "../core/dom";
import { length, micro, type Axis, type Column } from "./document";
import type { Editor } from "./editor";

/** Rows shown at once. */
const ROWS = 200;

export class Points {
  readonly root: HTMLElement;
  private axis: Axis | undefined;
  private columns: Column[] = [];
  private first = 0;
  private readonly head = el("tr");
  private readonly body = el("tbody");
  private readonly caption = el("caption");
  private readonly from: ReturnType<typeof numberField>;
  private inserted = 0;

  constructor(private readonly editor: Editor) {
    this.from = numberField({ label: "Rows from", value: 1, min: 1, step: 1 }, (value) => {
      this.first = Math.max(0, Math.round(value) - 1);
      this.fill();
    });
    const position = numberField({ label: "Position of a new row", value: 0 }, (value) => (this.inserted = value));
    const insert = button("Insert row", () => {
      this.inserted = position.input.valueAsNumber;
      const axis = this.axis?.axis;
      if (axis && Number.isFinite(this.inserted)) void this.editor.apply({ change: "insert", axis, position: this.inserted }, `axis ${axis}: row inserted at ${this.inserted}`, "");
    });
    const table = el("table", { class: "points" }, this.caption, el("thead", {}, this.head), this.body);
    this.root = el(
      "div",
      {},
      el("div", { class: "rows points", tabindex: 0, role: "group", "aria-label": "Numbers of the table" }, table),
      el("div", { class: "row tight" }, position.root, insert, this.from.root),
    );
  }

  set(axis: Axis | undefined, columns: Column[]): void {
    const other = axis?.axis !== this.axis?.axis;
    this.axis = axis;
    this.columns = columns;
    if (other) this.first = 0;
    this.root.hidden = columns.length === 0;
    this.fill();
  }

  private fill(): void {
    const table = this.axis?.table;
    if (!this.axis || !table) {
      this.body.replaceChildren();
      return;
    }
    const all = [...table.columns.filter(({ component }) => component === null), ...this.columns];
    const rows = table.rows.length;
    this.first = Math.min(this.first, Math.max(0, rows - ROWS));
    this.from.root.hidden = rows <= ROWS;
    this.from.value = this.first + 1;
    const last = Math.min(rows, this.first + ROWS);
    this.caption.textContent = `${table.file}, row ${this.first + 1} to ${last} of ${rows}`;
    this.head.replaceChildren(...["Row", ...all.map((column) => this.title(column)), ""].map((name) => el("th", { scope: "col" }, name)));
    const shown: HTMLElement[] = [];
    for (let row = this.first; row < last; row += 1) {
      const old = this.body.children[row - this.first] as HTMLTableRowElement | undefined;
      shown.push(this.row(row, all, old));
    }
    while (this.body.children.length > shown.length) this.body.lastChild?.remove();
    shown.forEach((line, i) => {
      if (this.body.children[i] !== line) this.body.append(line);
    });
  }

  private title({ name, component }: Column): string {
    const unit = component === null ? length(this.axis?.unit ?? "mm") : micro(component < 3 ? "um" : "urad");
    return `${name.replace(/_(mm|deg|um|urad)$/, "").replace("_fwd", " positive").replace("_rev", " negative")} / ${unit}`;
  }

  /** A line of inputs; an existing one is reused, so that the cursor stays. */
  private row(row: number, all: Column[], old: HTMLTableRowElement | undefined): HTMLElement {
    const names = all.map(({ name }) => name).join();
    const table = this.axis?.table;
    const line = old?.dataset.names === names ? old : this.line(all, names);
    if (old && old !== line) old.replaceWith(line);
    if (line.firstChild) line.firstChild.textContent = String(row + 1);
    line.querySelector("button")?.setAttribute("aria-label", `Remove row ${row + 1}`);
    all.forEach((column, i) => {
      const input = line.querySelectorAll("input")[i];
      const value = table?.rows[row]?.[table.columns.indexOf(column)];
      if (!input || value === undefined) return;
      const position = table?.rows[row]?.[table.columns.findIndex(({ component }) => component === null)] ?? 0;
      input.setAttribute("aria-label", column.component === null ? `${column.name}, row ${row + 1}` : `${column.name} at ${position}`);
      input.dataset.value = String(value);
      if (input.dataset.typed !== undefined) return;
      if (input.value !== String(value)) input.value = String(value);
      input.setAttribute("aria-invalid", "false");
    });
    return line;
  }

  private line(all: Column[], names: string): HTMLTableRowElement {
    const number = () => this.first + line.sectionRowIndex;
    const cells = all.map((column) => {
      const input = el("input", { type: "number", step: "any" });
      // A response to an earlier change must not overwrite the value being typed.
      input.addEventListener("input", () => (input.dataset.typed = ""));
      input.addEventListener("change", () => {
        delete input.dataset.typed;
        const valid = input.value !== "" && input.checkValidity();
        input.setAttribute("aria-invalid", String(!valid));
        const axis = this.axis?.axis;
        if (!valid || !axis || input.value === input.dataset.value) return;
        const value = input.valueAsNumber;
        void this.editor.apply({ change: "point", axis, column: column.name, row: number(), value }, `${column.name}, row ${number() + 1}: ${value}`, "");
      });
      return el("td", {}, input);
    });
    const remove = button("Remove", () => {
      const axis = this.axis?.axis;
      if (axis) void this.editor.apply({ change: "remove", axis, row: number() }, `axis ${axis}: row ${number() + 1} removed`, "");
    });
    const line = el("tr", { "data-names": names }, el("th", { scope: "row" }), ...cells, el("td", {}, remove));
    return line;
  }
}
