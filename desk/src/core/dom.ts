// Page elements: every control has a visible label and works by keyboard.

import { fixed } from "./number";
import type { Cell } from "./shown-types";

export type Child = Node | string | null | undefined;
type Attributes = Record<string, string | number | boolean | ((event: never) => void) | undefined>;

/** An element with attributes, listeners (`onclick`), and children. */
export function el<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    if (typeof value === "function") element.addEventListener(key.replace(/^on/, ""), value as EventListener);
    else element.setAttribute(key, value === true ? "" : String(value));
  }
  element.append(...children.filter((child): child is Node | string => child !== null && child !== undefined));
  if (name === "table") scrolls.observe(element);
  return element;
}

/** Makes tables that are wider than a narrow page reachable by keyboard, so that arrow keys scroll them. */
const scrolls = new ResizeObserver((entries) => {
  for (const { target } of entries) {
    if (target.scrollWidth > target.clientWidth + 1) target.setAttribute("tabindex", "0");
    else target.removeAttribute("tabindex");
  }
});

let count = 0;
/** An id that no other element has. */
export function unique(prefix: string): string {
  count += 1;
  return `${prefix}-${count}`;
}

export function button(text: string, onClick: () => void, attributes: Attributes = {}): HTMLButtonElement {
  return el("button", { type: "button", onclick: onClick, ...attributes }, text);
}

/** An input with its label and unit. */
export interface Field {
  root: HTMLElement;
  input: HTMLInputElement;
  value: number;
}

export interface FieldOptions {
  label: string;
  unit?: string;
  value: number;
  min?: number;
  max?: number;
  step?: number;
  /** Shown under the input. */
  hint?: string;
}

/** A number input. Marks text that is not a number or out of range, and does not report it. */
export function numberField(options: FieldOptions, onChange: (value: number) => void): Field {
  const id = unique("number");
  const { min, max, step } = options;
  const input = el("input", { id, type: "number", min, max, step: step ?? "any", value: options.value });
  const label = options.unit ? `${options.label} / ${options.unit}` : options.label;
  const root = el("div", { class: "field" }, el("label", { for: id }, label), input);
  if (options.hint) root.append(el("small", {}, options.hint));
  const take = () => {
    const valid = input.value.trim() !== "" && input.checkValidity();
    input.setAttribute("aria-invalid", String(!valid));
    if (valid) onChange(input.valueAsNumber);
  };
  input.addEventListener("change", take);
  return field(root, input);
}

/** A slider and a number input for the same value. */
export function slider(options: FieldOptions & { min: number; max: number }, onChange: (value: number) => void): Field {
  const numbers = numberField(options, (value) => {
    range.value = String(value);
    onChange(value);
  });
  const range = el("input", {
    type: "range",
    "aria-label": `${options.label}, slider`,
    min: options.min,
    max: options.max,
    step: options.step ?? "any",
    value: options.value,
  });
  range.addEventListener("input", () => {
    numbers.input.value = String(range.valueAsNumber);
    numbers.input.setAttribute("aria-invalid", "false");
    onChange(range.valueAsNumber);
  });
  numbers.input.after(range);
  numbers.root.classList.add("slider");
  const both = field(numbers.root, numbers.input);
  Object.defineProperty(both, "value", {
    get: () => numbers.input.valueAsNumber,
    set: (value: number) => {
      numbers.input.value = String(value);
      range.value = String(value);
    },
  });
  return both;
}

function field(root: HTMLElement, input: HTMLInputElement): Field {
  return {
    root,
    input,
    get value() {
      return input.valueAsNumber;
    },
    set value(value: number) {
      input.value = String(value);
    },
  };
}

/** An input for an optional number: null while it is empty. Marks text that is not a number. */
export function optionalField(label: string, unit: string, placeholder: string, onChange: (value: number | null) => void): Field {
  const field = numberField({ label, unit, value: Number.NaN }, () => undefined);
  field.input.placeholder = placeholder;
  field.input.addEventListener("change", () => {
    field.input.setAttribute("aria-invalid", String(field.input.validity.badInput));
    onChange(field.input.value === "" ? null : field.value);
  });
  return field;
}

/** A text input that reports every change while the user types. */
export function textField(label: string, placeholder: string, onInput: () => void, type: "text" | "number" = "text"): { root: HTMLElement; input: HTMLInputElement } {
  const id = unique("text");
  // Reports on input, not when the field loses the focus: otherwise the click on a button that takes the focus would be lost.
  const input = el("input", { id, type, placeholder, oninput: onInput });
  return { root: el("div", { class: "field" }, el("label", { for: id }, label), input), input };
}

/** A choice of named options. */
export function choice<T extends string>(
  label: string,
  options: ReadonlyArray<readonly [T, string]>,
  value: T,
  onChange: (value: T) => void,
): { root: HTMLElement; select: HTMLSelectElement; value: T } {
  const id = unique("choice");
  const select = el("select", { id });
  for (const [key, text] of options) select.append(el("option", { value: key, selected: key === value }, text));
  select.addEventListener("change", () => onChange(select.value as T));
  return {
    root: el("div", { class: "field" }, el("label", { for: id }, label), select),
    select,
    get value() {
      return select.value as T;
    },
    set value(value: T) {
      select.value = value;
    },
  };
}

/** A box to tick. */
export function tick(label: string, checked: boolean, onChange: (checked: boolean) => void): { root: HTMLElement; input: HTMLInputElement } {
  const input = el("input", { type: "checkbox", checked });
  input.addEventListener("change", () => onChange(input.checked));
  return { root: el("label", { class: "tick" }, input, ` ${label}`), input };
}

export type { Cell };

/** A table with a caption; the first cell of a row is its header. `data-value` keeps numbers at full precision. */
export function table(caption: string, header: readonly string[], rows: ReadonlyArray<readonly Cell[]>): HTMLTableElement {
  const root = el("table", {}, el("caption", {}, caption));
  root.append(el("thead", {}, el("tr", {}, ...header.map((name) => el("th", { scope: "col" }, name)))));
  const body = el("tbody");
  for (const row of rows) {
    const cells = row.map((cell, column) => {
      const text = typeof cell === "string" ? cell : cell.text;
      const whole = typeof cell === "string" ? {} : { "data-value": String(cell.value), class: "number" };
      return column === 0 ? el("th", { scope: "row", ...whole }, text) : el("td", whole, text);
    });
    body.append(el("tr", {}, ...cells));
  }
  root.append(body);
  return root;
}

/** Puts a bar behind every row of a table, as long as its share of 1. */
export function bars(of: HTMLTableElement, shares: readonly number[]): void {
  for (const [i, row] of [...of.tBodies[0]!.rows].entries())
    row.append(el("td", { "aria-hidden": "true" }, el("div", { class: "share", style: `width: ${fixed(120 * shares[i]!, 1)}px` })));
}

/** Sentences one below the other; hidden without any. */
export function notes(name: string, texts: readonly string[], own = ""): HTMLElement {
  return el("ul", { class: `notes ${own}`, "aria-label": name, hidden: texts.length === 0 }, ...texts.map((text) => el("li", {}, text)));
}

/** Warnings about a result. */
export function warnings(texts: readonly string[]): HTMLElement {
  return notes("Warnings", texts, "warning");
}

/** The parts of a typed list, between commas or spaces. */
export function typed(list: string): string[] {
  return list.split(/[,\s]+/).filter((part) => part !== "");
}

/** A part of a view, with its heading. */
export function section(title: string, ...children: Child[]): HTMLElement {
  const id = unique("section");
  return el("section", { "aria-labelledby": id }, el("h2", { id }, title), ...children);
}

/** Controls side by side. */
export function group(legend: string, ...children: Child[]): HTMLFieldSetElement {
  return el("fieldset", {}, el("legend", {}, legend), ...children);
}

/** A command line that gives the same result, with a button that copies it. */
export function commandLine(title: string): { root: HTMLElement; set(text: string): void; text(): string } {
  const code = el("code");
  const said = el("span", { role: "status", class: "said" });
  const copy = button("Copy", () => {
    void navigator.clipboard.writeText(code.textContent ?? "").then(
      () => (said.textContent = "copied"),
      () => (said.textContent = "not permitted here: select the text and copy it"),
    );
  });
  return {
    root: el("div", { class: "command" }, el("span", { class: "title" }, title), code, copy, said),
    set: (text) => {
      code.textContent = text;
      said.textContent = "";
    },
    text: () => code.textContent ?? "",
  };
}

/** Calls `action` once after the last of several requests. */
export function debounce(delay_ms: number, action: () => void): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(action, delay_ms);
  };
}
