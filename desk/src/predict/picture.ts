// The part in three dimensions: every feature in the colour of its verdict, with magnified deviations.

import { choice, el } from "../core/dom";
import { Scene } from "../core/scene";
import type { Vector } from "../core/space";
import type { ColourName } from "../core/theme";
import { oneTwoFive } from "../machine/field-picture";
import type { Shape, Verdict } from "./documents";

/** Length of the largest deviation as a share of the part. */
const LARGEST = 0.06;
/** Cones of a feature. */
const CONES = 13;

/** Colour, sign and words of a verdict: the sign and the words say it without colour. */
export const VERDICTS: Record<Verdict | "unknown", { colour: ColourName; sign: string; text: string }> = {
  conforms: { colour: "after", sign: "✓", text: "conforms" },
  undecided: { colour: "before", sign: "?", text: "undecided" },
  "does not conform": { colour: "warning", sign: "✗", text: "does not conform" },
  unknown: { colour: "servo", sign: "", text: "no verdict" },
};

type Deviations = "corrected_um" | "uncorrected_um" | "everything_um";

export class Picture {
  readonly root: HTMLElement;
  private readonly scene: Scene;
  private readonly caption = el("figcaption");
  private readonly keys = el("div", { class: "keys" });
  private readonly which;
  private shapes: Shape[] = [];
  private chosen = "";

  constructor() {
    const figure = el("figure", {}, this.caption);
    this.scene = new Scene(figure, { label: "The part with its features in the colour of their verdict and their deviations as cones", height: 380 });
    this.scene.viewFrom(-1.1, 0.7);
    this.which = choice<Deviations>("Deviations shown", [["corrected_um", "corrected"], ["uncorrected_um", "uncorrected"], ["everything_um", "everything on"]], "corrected_um", () => this.draw());
    figure.append(this.keys, el("div", { class: "row" }, this.which.root));
    this.which.select.options[2]!.hidden = true;
    this.root = figure;
  }

  /** `chosen`: the feature that is marked. */
  set(shapes: Shape[], chosen: string): void {
    const hasServo = shapes.some(({ everything_um }) => everything_um);
    const option = this.which.select.options[2]!;
    // With the servo the verdicts are those of everything on.
    if (hasServo && option.hidden) this.which.value = "everything_um";
    else if (!hasServo && this.which.value === "everything_um") this.which.value = "corrected_um";
    option.hidden = option.disabled = !hasServo;
    [this.shapes, this.chosen] = [shapes, chosen];
    this.draw();
  }

  private draw(): void {
    const { scene, shapes } = this;
    const points = shapes.flatMap(({ points_mm }) => points_mm);
    if (points.length === 0) return;
    const end = (pick: (...all: number[]) => number) => [0, 1, 2].map((k) => pick(...points.map((point) => point[k]!))) as Vector;
    const [low, high] = [end(Math.min), end(Math.max)];
    const size = Math.hypot(...high.map((q, k) => q - low[k]!)) || 1;
    const which = this.which.value;
    const deviations = (shape: Shape) => shape[which] ?? shape.corrected_um;
    // One magnification for both, so that they compare.
    const largest = Math.max(1e-3, ...shapes.flatMap((shape) => [...shape.uncorrected_um, ...shape.corrected_um].map((um) => Math.hypot(...um))));
    const magnification = oneTwoFive((LARGEST * size) / (largest * 1e-3));
    scene.clear();
    scene.fit(low, high);
    scene.box(low, high, ["X / mm", "Y / mm", "Z / mm"]);
    for (const shape of shapes) {
      const { colour, sign } = VERDICTS[shape.verdict ?? "unknown"];
      const line = shape.closed ? [...shape.points_mm, shape.points_mm[0]!] : shape.points_mm;
      scene.polyline(new Float32Array(line.flat()), colour);
      const own = Array.from({ length: Math.min(CONES, line.length) }, (_, k) => Math.round((k * (shape.points_mm.length - 1)) / Math.max(1, Math.min(CONES, line.length) - 1)));
      const vectors = own.flatMap((k) => deviations(shape)[k]!);
      scene.cones(own.flatMap((k) => shape.points_mm[k]!), vectors, colour, magnification * 1e-3, size * 0.008);
      const marked = shape.feature === this.chosen;
      if (marked || shape.kind === "hole") scene.points(new Float32Array(shape.points_mm.flat()), colour, marked ? 7 : 5);
      scene.label(shape.points_mm[Math.floor(shape.points_mm.length / 2)]!, `${sign} ${shape.feature}`.trim());
    }
    scene.draw();
    const name = this.which.select.selectedOptions[0]!.text;
    this.caption.textContent = `Part, ${name}: deviations magnified ${magnification.toLocaleString("en")} times, at most ${largest.toFixed(1)} µm uncorrected`;
    const found = new Set(shapes.map(({ verdict }) => verdict ?? "unknown"));
    const key = (verdict: Verdict | "unknown") => {
      const { colour, sign, text } = VERDICTS[verdict];
      return el("span", {}, el("span", { class: "swatch", style: `background: var(--${colour})`, "aria-hidden": "true" }), `${sign} ${text}`.trim());
    };
    this.keys.replaceChildren(...(Object.keys(VERDICTS) as (Verdict | "unknown")[]).filter((verdict) => found.has(verdict)).map(key));
  }
}
