// Updates of a machine by re-probing balls.

import "../core/figures.css";
import "../calibrate/calibrate.css";
import type { View } from "../core/desk";
import { Keep, type ViewState } from "./panel";

let keep: Keep | undefined;

export const view: View = {
  id: "keep",
  title: "Keep",
  build: (root, desk) => {
    keep = new Keep(root, desk);
  },
  state: () => keep?.state,
  open: async (state) => {
    const kept = state as Partial<ViewState> | null;
    if (typeof kept?.name !== "string" || typeof kept.task !== "string" || typeof kept.history !== "string") throw new Error("keep: found a state without a task, needed one that this page saved");
    keep?.open(kept as ViewState);
  },
};
