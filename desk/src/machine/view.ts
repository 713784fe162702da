// The machine view: tables and settings, their effect, and export to the controller.

import "./machine.css";
import type { Desk, View } from "../core/desk";
import { el } from "../core/dom";
import { display } from "./display";
import { Editor } from "./editor";
import { exporting } from "./exporting";
import { fieldSection, type FieldSection } from "./field";
import { accuracy, identity, limits, warnings } from "./figures";
import { grids } from "./grids";
import { opening } from "./opening";
import { Settings } from "./settings";
import { Tables } from "./tables";

interface State {
  axis?: string;
  component?: number;
  temperature_c?: number | null;
  rate_hz?: number;
  feed_per_min?: number;
  field?: unknown;
}

let parts: { editor: Editor; tables: Tables; field: FieldSection } | undefined;

async function build(root: HTMLElement, desk: Desk): Promise<void> {
  const editor = new Editor(desk);
  const tables = new Tables(desk, editor);
  const settings = new Settings(editor, tables);
  root.append(
    await opening(root, desk, editor),
    identity(editor),
    el("div", { class: "columns" }, el("div", {}, tables.root, settings.own), el("div", {}, settings.root, warnings(editor), exporting(desk, editor))),
    grids(editor),
    limits(editor),
    accuracy(editor),
  );
  // The keys work on the whole page while this view is visible, wherever the focus is.
  document.addEventListener("keydown", (event) => root.hidden || keys(event, editor));
  const field = fieldSection(root, desk);
  display.subscribe((temperature) => {
    const reference = editor.shown?.reference_temperature_c ?? 20;
    const seen = field.state() as { request: { kelvin: number } };
    seen.request.kelvin = Number(((display.temperature_c === undefined ? reference : temperature) - reference).toPrecision(12));
    field.open(seen);
  });
  parts = { editor, tables, field };
  await editor.refresh();
}

/** Ctrl+Z and Ctrl+Shift+Z or Ctrl+Y, unless text is being typed. */
function keys(event: KeyboardEvent, editor: Editor): void {
  if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
  const { target } = event;
  if (target instanceof HTMLInputElement && target.dataset.value !== undefined && target.value !== target.dataset.value) return;
  const key = event.key.toLowerCase();
  if (key !== "z" && key !== "y") return;
  event.preventDefault();
  void (key === "y" || event.shiftKey ? editor.redo() : editor.undo());
}

function state(): State {
  if (!parts) return {};
  const { editor, tables, field } = parts;
  const { rate_hz, feed_per_min } = editor;
  return { ...tables.chosen, temperature_c: display.temperature_c ?? null, rate_hz, feed_per_min, field: field.state() };
}

async function open(kept: unknown): Promise<void> {
  if (!parts) return;
  const { editor, tables, field } = parts;
  const { axis, component, temperature_c, rate_hz, feed_per_min, field: seen } = (kept ?? {}) as State;
  editor.rate_hz = rate_hz ?? editor.rate_hz;
  editor.feed_per_min = feed_per_min ?? editor.feed_per_min;
  display.set(temperature_c ?? undefined);
  await editor.refresh();
  tables.choose({ axis: axis ?? tables.chosen.axis, component: component ?? tables.chosen.component });
  if (seen) field.open(seen);
}

export const view: View = { id: "machine", title: "Machine", build, shown: () => parts?.field.refresh(), state, open };
