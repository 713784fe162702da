// Points of a table on its plot: dragged, or moved by keyboard.

import type { Plot } from "../core/plot";
import { onTheme } from "../core/theme";
import { el } from "../core/dom";
import { fixed } from "../core/number";

export interface Point {
  row: number;
  position: number;
  value: number;
}

/** The points of one column. */
export interface PointsOf {
  column: string;
  direction: "forward" | "reverse";
  unit: string;
  positionUnit: string;
  points: Point[];
  /** Offset of the curve above the points: backlash. */
  offset: number;
}

/** Above this number only visible points have handles. */
const MOST = 400;
/** Step of a key press, µm or µrad. */
const STEP = 0.1;

export class Handles {
  private readonly layer = el("div", { class: "handles", role: "group", "aria-label": "Points of the table" });
  private columns: PointsOf[] = [];
  private hooked: unknown;
  /** The point with keyboard focus. */
  private at = { column: 0, row: 0 };
  private drag: { element: HTMLElement; column: PointsOf; point: Point; y: number; value: number; perPixel: number } | undefined;

  /** Value requested by keyboard that the machine does not show yet: the next press starts from it. */
  private keyed: { column: string; row: number; value: number; settled: boolean } | undefined;

  constructor(
    private readonly plot: Plot,
    private readonly move: (column: string, row: number, value: number, gesture: number) => Promise<void>,
  ) {
    // The role `img` permits no children, but this element has some.
    plot.root.querySelector(".plot")?.setAttribute("role", "group");
    onTheme(this, (handles) => handles.place());
    new ResizeObserver(() => requestAnimationFrame(() => this.place())).observe(plot.root);
    this.layer.addEventListener("keydown", (event) => this.key(event));
    this.layer.addEventListener("pointerdown", (event) => this.grasp(event));
    this.layer.addEventListener("pointermove", (event) => this.pull(event));
    for (const name of ["pointerup", "pointercancel"] as const) this.layer.addEventListener(name, () => (this.drag = undefined));
    // Dragging on the plot itself zooms.
    for (const name of ["mousedown", "dblclick"] as const) this.layer.addEventListener(name, (event) => event.stopPropagation());
  }

  set(columns: PointsOf[]): void {
    this.columns = columns;
    if (this.keyed?.settled) this.keyed = undefined;
    this.place();
  }

  /** Places the handles on the plotted points. */
  private place(): void {
    const plot = this.plot.inner;
    if (!plot) return;
    if (this.hooked !== plot) {
      this.hooked = plot;
      plot.over.append(this.layer);
      (plot.hooks.draw as ((self: typeof plot) => void)[]).push(() => this.place());
    }
    const [low, high] = [plot.scales.x?.min ?? 0, plot.scales.x?.max ?? 0];
    const focused = this.layer.contains(document.activeElement);
    const old = new Map([...this.layer.children].map((child) => [(child as HTMLElement).dataset.key, child as HTMLElement]));
    const now: HTMLElement[] = [];
    this.columns.forEach((of, column) => {
      const seen = of.points.filter(({ position }) => position >= low && position <= high);
      if (seen.length > MOST) return;
      for (const point of seen) {
        const key = `${of.column} ${point.row}`;
        const handle = old.get(key) ?? el("div", { class: `handle ${of.direction}`, role: "slider", "aria-orientation": "vertical", "data-key": key });
        handle.dataset.column = String(column);
        handle.dataset.row = String(point.row);
        handle.tabIndex = this.at.column === column && this.at.row === point.row ? 0 : -1;
        const held = this.drag?.element === handle ? this.drag.value : point.value;
        handle.style.transform = `translate(${plot.valToPos(point.position, "x")}px, ${plot.valToPos(held + of.offset, "y")}px)`;
        handle.setAttribute("aria-label", `${of.column} at ${point.position} ${of.positionUnit}`);
        handle.setAttribute("aria-valuenow", String(point.value));
        handle.setAttribute("aria-valuetext", `${point.value} ${of.unit}`);
        handle.title = `${of.column} at ${fixed(point.position, 3)} ${of.positionUnit}: ${fixed(point.value, 3)} ${of.unit}`;
        now.push(handle);
      }
    });
    if (now.length > 0 && !now.some((handle) => handle.tabIndex === 0)) now[0]!.tabIndex = 0;
    if (now.length !== this.layer.children.length || now.some((handle, i) => handle !== this.layer.children[i])) {
      this.layer.replaceChildren(...now);
      if (focused) now.find((handle) => handle.tabIndex === 0)?.focus();
    }
  }

  private of(target: EventTarget | null): { element: HTMLElement; column: PointsOf; point: Point } | undefined {
    const element = target instanceof HTMLElement ? target.closest<HTMLElement>(".handle") : null;
    const column = element && this.columns[Number(element.dataset.column)];
    const point = column?.points.find(({ row }) => row === Number(element?.dataset.row));
    return element && column && point ? { element, column, point } : undefined;
  }

  private grasp(event: PointerEvent): void {
    const found = this.of(event.target);
    const plot = this.plot.inner;
    if (!found || !plot || event.button !== 0) return;
    event.preventDefault();
    found.element.focus();
    found.element.setPointerCapture(event.pointerId);
    this.at = { column: this.columns.indexOf(found.column), row: found.point.row };
    const perPixel = plot.posToVal(0, "y") - plot.posToVal(1, "y");
    gestures += 1;
    this.drag = { ...found, y: event.clientY, value: found.point.value, perPixel };
  }

  private pull(event: PointerEvent): void {
    const { drag } = this;
    if (!drag) return;
    const wanted = drag.point.value + (drag.y - event.clientY) * drag.perPixel;
    // Rounded to a round number no finer than a pixel.
    const grain = 10 ** Math.floor(Math.log10(Math.max(drag.perPixel, 1e-3)));
    const value = Number((Math.round(wanted / grain) * grain).toFixed(3));
    if (value === drag.value) return;
    drag.value = value;
    const plot = this.plot.inner;
    if (plot) drag.element.style.transform = `translate(${plot.valToPos(drag.point.position, "x")}px, ${plot.valToPos(value + drag.column.offset, "y")}px)`;
    void this.move(drag.column.column, drag.point.row, value, gestures);
  }

  private key(event: KeyboardEvent): void {
    const found = this.of(event.target);
    if (!found || event.ctrlKey || event.metaKey) return;
    const { column, point } = found;
    const index = column.points.indexOf(point);
    const to = { ArrowLeft: index - 1, ArrowRight: index + 1, Home: 0, End: column.points.length - 1 }[event.key];
    if (to !== undefined && !event.altKey) {
      event.preventDefault();
      this.focus(this.columns.indexOf(column), column.points[to]?.row);
      return;
    }
    const size = event.altKey ? STEP / 10 : event.shiftKey ? STEP * 10 : STEP;
    const by = { ArrowUp: size, ArrowDown: -size, PageUp: STEP * 10, PageDown: -STEP * 10 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    const { keyed } = this;
    const now = keyed && keyed.column === column.column && keyed.row === point.row ? keyed.value : point.value;
    const asked = { column: column.column, row: point.row, value: Number((now + by).toFixed(3)), settled: false };
    this.keyed = asked;
    void this.move(asked.column, asked.row, asked.value, -1).finally(() => (asked.settled = true));
  }

  private focus(column: number, row: number | undefined): void {
    if (row === undefined) return;
    this.at = { column, row };
    this.place();
    this.layer.querySelector<HTMLElement>(".handle[tabindex='0']")?.focus();
  }
}

let gestures = 0;
