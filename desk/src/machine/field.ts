// The volumetric error over the working volume, before and after the correction, updated with the machine.

import "./field.css";
import { message, type Desk } from "../core/desk";
import { choice, el, group, numberField, section, slider, tick, type Field } from "../core/dom";
import type { Figures, Model, Request, Triple } from "./field-document";
import { modelName, Rows } from "./field-document";
import { Picture, type Layout } from "./field-picture";
import { Slice } from "./field-slice";
import { causes, figuresTable, PointsTable, sent, summary } from "./field-tables";

interface State {
  request: Request;
  layout: Layout;
  ownScale: boolean;
  slice: { across: number; index: number };
}

export interface FieldSection {
  /** Updates for another machine, or when the section becomes visible. */
  refresh(): void;
  state(): unknown;
  open(state: unknown): void;
}

/** Builds the section into `root`; it computes only while it is visible. */
export function fieldSection(root: HTMLElement, desk: Desk): FieldSection {
  return new FieldView(root, desk);
}

class FieldView implements FieldSection {
  private request: Request = { points: 11, kelvin: 0, negative: "", pose_deg: {} };
  private busy = false;
  private stale = true;
  private visible = false;
  /** Machine of the request, and chain of the controls. */
  private machine = "";
  private chain = "";
  private readonly status = el("p", { role: "status", class: "said" });
  private readonly refused = el("p", { class: "warning", role: "alert", hidden: true });
  private readonly words = el("p", {});
  private readonly figures = el("div", {});
  private readonly causes = el("div", { class: "causes" });
  private readonly travel = group("Negative travel");
  private readonly pose = group("Pose of the rotary axes");
  private readonly points: Field;
  private readonly kelvin: Field;
  private readonly model: { root: HTMLElement; value: "own" | Model };
  private readonly tool: Field[];
  private readonly picture: Picture;
  private readonly slice: Slice;
  private readonly table: PointsTable;

  constructor(
    root: HTMLElement,
    private readonly desk: Desk,
  ) {
    this.points = slider({ label: "Points along each axis", value: 11, min: 5, max: 21, step: 1 }, (points) => this.ask({ points }));
    this.kelvin = slider({ label: "Temperature above the reference", unit: "K", value: 0, min: -20, max: 20, step: 0.1 }, (kelvin) => this.ask({ kelvin }));
    const models = [["own", "the machine's own"], ["nine", "nine terms"], ["volumetric", "volumetric"]] as const;
    this.model = choice<"own" | Model>("Model of the correction", models, "own", (model) => {
      if (model === "own") delete this.request.model;
      this.ask(model === "own" ? {} : { model });
    });
    this.tool = (["X", "Y", "Z"] as const).map((letter) => numberField({ label: letter, unit: "mm", value: 0 }, () => this.ask({ tool_mm: this.tool.map((one) => one.value) as Triple })));
    const controls = el("div", { class: "row" }, this.points.root, this.kelvin.root, this.model.root, this.travel, this.pose, group("Tool tip from the last frame", ...this.tool.map((one) => one.root)));
    const pictures = el("div", {});
    const slices = el("div", {});
    const own = section("Volumetric error", controls, this.refused, this.words, pictures, this.figures, el("h3", {}, "Worst point"), this.causes, el("h3", {}, "Slices"), slices, this.status);
    own.classList.add("field-section");
    root.append(own);
    this.picture = new Picture(pictures, () => this.slice?.paint());
    this.slice = new Slice(slices, (half) => this.picture.full(half));
    this.table = new PointsTable(own);
    desk.machine.subscribe(() => this.changed());
    new IntersectionObserver((entries) => {
      this.visible = entries.at(-1)?.isIntersecting ?? false;
      void this.work();
    }).observe(own);
    this.machine = desk.machine.name;
  }

  refresh(): void {
    this.stale = true;
    void this.work();
  }

  state(): State {
    return { request: this.request, layout: this.picture.layout, ownScale: this.picture.ownScale, slice: this.slice.state() };
  }

  open(state: unknown): void {
    const { request, layout, ownScale, slice } = state as State;
    this.request = request;
    this.machine = this.desk.machine.name;
    this.chain = "";
    this.points.value = request.points;
    this.kelvin.value = request.kelvin;
    this.model.value = request.model ?? "own";
    this.slice.open(slice);
    this.picture.set(layout, ownScale);
    this.refresh();
  }

  private ask(change: Partial<Request>): void {
    Object.assign(this.request, change);
    this.refresh();
  }

  /** An edited machine keeps the request, another one only the parts that do not depend on its axes. */
  private changed(): void {
    if (this.desk.machine.name !== this.machine) {
      this.machine = this.desk.machine.name;
      const { points, kelvin, model } = this.request;
      this.request = { points, kelvin, negative: "", pose_deg: {}, ...(model ? { model } : {}) };
      this.chain = "";
    }
    this.refresh();
  }

  /** One computation at a time, always of the latest request. */
  private async work(): Promise<void> {
    if (this.busy || !this.stale || !this.visible || this.desk.machine.name === "") return;
    this.busy = true;
    this.stale = false;
    try {
      await this.compute();
      this.refused.hidden = true;
    } catch (error) {
      this.refused.textContent = message(error);
      this.refused.hidden = false;
    }
    this.busy = false;
    void this.work();
  }

  private async compute(): Promise<void> {
    const { json } = this.desk.machine;
    const request = JSON.stringify(this.request);
    const start = performance.now();
    const rows = new Rows(await this.desk.bench.call("field", json, request));
    const took = performance.now() - start;
    const figures = JSON.parse(await this.desk.bench.call("field_figures", json, request)) as Figures;
    if (figures.chain !== this.chain) this.suit(figures);
    this.picture.show(rows, figures);
    this.slice.show(rows, figures);
    this.table.show(rows);
    this.words.textContent = summary(figures);
    this.figures.replaceChildren(figuresTable(figures));
    this.causes.replaceChildren(causes("Worst point before", figures.before.worst));
    const after = figures[figures.model].after;
    if (after) {
      const title = `Worst point after, ${modelName[figures.model]}`;
      this.causes.append(el("div", {}, causes(title, after.worst), sent(title, after.worst)));
    }
    this.status.textContent = `Errors are actual − ideal, of the tool relative to the workpiece, in machine directions (ISO 230-1). ${rows.count.toLocaleString("en")} points in ${Math.round(took)} ms.`;
    this.status.dataset.milliseconds = String(took);
    if (!this.request.tool_mm) for (const [axis, one] of this.tool.entries()) one.value = figures.tool_mm[axis]!;
  }

  /** Controls of the axes that the machine has. */
  private suit({ chain, travel_deg }: Figures): void {
    this.chain = chain;
    const letters = [..."XYZABC"].filter((letter) => chain.includes(letter));
    const travel = (letter: string) => (checked: boolean) => {
      const others = [...this.request.negative].filter((one) => one !== letter).join("");
      this.ask({ negative: checked ? others + letter : others });
    };
    const ticks = letters.map((letter) => tick(letter, this.request.negative.includes(letter), travel(letter)).root);
    this.travel.replaceChildren(this.travel.firstElementChild!, ...ticks);
    const turns = Object.entries(travel_deg).map(([letter, [low, high]]) => {
      const [min, max] = [Math.max(-360, low), Math.min(360, high)];
      const turn = (degrees: number) => this.ask({ pose_deg: { ...this.request.pose_deg, [letter]: degrees } });
      return slider({ label: letter, unit: "°", value: this.request.pose_deg[letter] ?? 0, min, max, step: 0.1 }, turn).root;
    });
    this.pose.replaceChildren(this.pose.firstElementChild!, ...turns);
    this.pose.hidden = turns.length === 0;
  }
}
