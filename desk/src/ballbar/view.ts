// Circular tests.

import "../core/figures.css";
import "./ballbar.css";
import type { View } from "../core/desk";
import { Ballbar, type ViewState } from "./panel";

let ballbar: Ballbar | undefined;

export const view: View = {
  id: "ballbar",
  title: "Ballbar",
  build: (root, desk) => {
    ballbar = new Ballbar(root, desk);
  },
  state: () => ballbar?.state,
  open: async (state) => {
    const kept = state as Partial<ViewState> | null;
    if (!kept?.request || kept.compensated === undefined) throw new Error("ballbar: found a state without the settings of a record, needed one that this page saved");
    ballbar?.open(kept as ViewState);
  },
};
