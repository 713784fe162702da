// Uncertainty of the corrected position.

import "../core/figures.css";
import "./uncertainty.css";
import type { View } from "../core/desk";
import { Position, type ViewState } from "./panel";

let position: Position | undefined;

export const view: View = {
  id: "uncertainty",
  title: "Uncertainty",
  build: (root, desk) => {
    position = new Position(root, desk);
  },
  state: () => position?.state,
  open: async (state) => {
    const kept = state as Partial<ViewState> | null;
    if (!kept?.request || typeof kept.at !== "string") throw new Error("uncertainty: found a state without a request, needed one that this page saved");
    position?.open(kept as ViewState);
  },
};
