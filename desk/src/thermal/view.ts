// Thermal growth.

import "../core/figures.css";
import "./thermal.css";
import type { View } from "../core/desk";
import { Growth, type ViewState } from "./panel";

let growth: Growth | undefined;

export const view: View = {
  id: "thermal",
  title: "Thermal growth",
  build: (root, desk) => {
    growth = new Growth(root, desk);
  },
  state: () => growth?.state,
  open: async (state) => {
    const kept = state as Partial<ViewState> | null;
    if (typeof kept?.holdOut !== "string" || typeof kept.without !== "string") throw new Error("thermal: found a state without cycles and sensors, needed one that this page saved");
    growth?.open(kept as ViewState);
  },
};
