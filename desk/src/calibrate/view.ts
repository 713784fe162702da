// Calibration with a touch probe.

import "../core/figures.css";
import "./calibrate.css";
import type { View } from "../core/desk";
import { Calibrate } from "./panel";
import type { ViewState } from "./probing";

let calibrate: Calibrate | undefined;

export const view: View = {
  id: "calibrate",
  title: "Calibrate",
  build: (root, desk) => {
    calibrate = new Calibrate(root, desk);
  },
  state: () => calibrate?.state,
  open: async (state) => {
    const kept = state as Partial<ViewState> | null;
    if (typeof kept?.name !== "string" || typeof kept.task !== "string") throw new Error("calibrate: found a state without a task, needed one that this page saved");
    calibrate?.open(kept as ViewState);
  },
};
