// Errors over two or three axes: along one of them at a time, at fixed positions of the others.

import { choice, el, section, slider } from "../core/dom";
import { significant } from "../core/number";
import { Plot } from "../core/plot";
import type { Grid } from "./document";
import type { Editor } from "./editor";

const LETTERS = ["X", "Y", "Z"] as const;
const COMPONENTS = ["EX", "EY", "EZ", "EA", "EB", "EC"] as const;
const COLOURS = ["x", "y", "z", "a", "b", "c"] as const;
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 4], [1, 2]];

export function grids(editor: Editor): HTMLElement {
  const place = el("div");
  const root = section("Grids of errors", place);
  editor.subscribe(() => {
    const all = editor.shown?.grids ?? [];
    root.hidden = all.length === 0;
    place.replaceChildren(...all.map((grid, i) => one(grid, `Grid ${i + 1}`)));
  });
  return root;
}

function one(grid: Grid, name: string): HTMLElement {
  const over = LETTERS.filter((_, axis) => grid.nodes_mm[axis]!.length > 0);
  const given = COMPONENTS.map((component, k) => ({ component, k })).filter(({ k }) => grid.given[k]);
  let along = over[0]!;
  const at = [0, 0, 0];
  const [controls, host] = [el("div", { class: "row" }), el("div")];

  const draw = () => {
    const axis = LETTERS.indexOf(along);
    const others = over.filter((letter) => letter !== along);
    const where = others.map((letter) => `${letter} ${significant(grid.nodes_mm[LETTERS.indexOf(letter)]![at[LETTERS.indexOf(letter)]!]!, 6)} mm`).join(", ");
    host.replaceChildren();
    const plot = new Plot(host, {
      title: `${name} along ${along} at ${where}`,
      x: `${along} / mm`,
      y: "error / µm, µrad",
      series: given.map(({ component, k }) => ({ name: component, colour: COLOURS[k]!, dash: DASHES[k]!, dots: true, unit: k < 3 ? "µm" : "µrad" })),
    });
    const values = given.map(({ k }) => grid.nodes_mm[axis]!.map((_, i) => grid.micro[row(grid, at.with(axis, i))]![k]!));
    plot.set([grid.nodes_mm[axis]!, ...values]);
  };
  const turn = () => {
    const sliders = over
      .filter((letter) => letter !== along)
      .map((letter) => {
        const axis = LETTERS.indexOf(letter);
        const options = { label: `Node of ${letter}`, value: at[axis]! + 1, min: 1, max: grid.nodes_mm[axis]!.length, step: 1 };
        return slider(options, (node) => {
          at[axis] = node - 1;
          draw();
        }).root;
      });
    const along_ = choice("Along", over.map((letter) => [letter, letter] as const), along, (letter) => {
      along = letter;
      turn();
    });
    controls.replaceChildren(along_.root, ...sliders);
    draw();
  };
  turn();
  const fades = grid.fade_mm ? `, fades out from Z ${grid.fade_mm[0]} to ${grid.fade_mm[1]} mm` : "";
  const counts = over.map((letter) => `${letter} ${grid.nodes_mm[LETTERS.indexOf(letter)]!.length}`).join(", ");
  return el("div", {}, el("p", {}, `${name}: nodes ${counts}${fades}.`), controls, host);
}

/** Index of a node: X is the outermost index, Z the innermost. */
function row({ nodes_mm }: Grid, [x, y, z]: number[]): number {
  const count = (axis: number) => Math.max(1, nodes_mm[axis]!.length);
  return (x! * count(1) + y!) * count(2) + z!;
}
