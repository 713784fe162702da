// Recorded circles: the effect of friction at the reversals, the identified friction, and the circles simulated with it.

import "./friction.css";
import type { View } from "../core/desk";
import { Friction, type ViewState } from "./panel";
import type { Settings } from "./source";

let friction: Friction | undefined;

export const view: View = {
  id: "friction",
  title: "Friction",
  build: async (root, desk) => {
    const usual = JSON.parse(await desk.bench.call("friction_settings")) as Settings;
    friction = new Friction(root, desk, usual);
    friction.begin();
  },
  state: () => friction?.state(),
  open: async (state) => friction?.open(state as ViewState),
};
