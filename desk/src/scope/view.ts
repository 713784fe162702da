// The servo scope: runs a part program through the real step with a simulated machine.

import type { Desk, View } from "../core/desk";
import { Scope } from "./scope";

let scope: Scope | undefined;

export const view: View = {
  id: "scope",
  title: "Servo scope",
  build: async (root: HTMLElement, desk: Desk) => {
    scope = new Scope(root, desk);
    await scope.start();
  },
  shown: () => scope?.visible(true),
  hidden: () => scope?.visible(false),
  state: () => scope?.state() ?? {},
  open: async (state) => scope?.show(state),
};
