// A part before it is cut.

import "./predict.css";
import type { View } from "../core/desk";
import { Part, type ViewState } from "./panel";

let part: Part | undefined;

export const view: View = {
  id: "predict",
  title: "Predict",
  build: (root, desk) => {
    part = new Part(root, desk);
  },
  state: () => part?.state,
  open: async (state) => {
    const kept = state as Partial<ViewState> | null;
    const isRequest = kept?.request === null || (kept?.request && Array.isArray(kept.request.part) && Array.isArray(kept.request.program));
    if (!isRequest) throw new Error("predict: found a state without a part and its program, needed one that this page saved");
    part?.open(kept as ViewState);
  },
};
