// Tests with instruments.

import "../core/figures.css";
import "./evaluate.css";
import type { View } from "../core/desk";
import { Evaluate, type ViewState } from "./panel";

let evaluate: Evaluate | undefined;

export const view: View = {
  id: "evaluate",
  title: "Tests",
  build: (root, desk) => {
    evaluate = new Evaluate(root, desk);
  },
  state: () => evaluate?.state,
  open: async (state) => {
    const kept = state as Partial<ViewState> | null;
    if (typeof kept?.chosen !== "string" || !kept.options) throw new Error("evaluate: found a state without a test and its options, needed one that this page saved");
    evaluate?.open(kept as ViewState);
  },
};
