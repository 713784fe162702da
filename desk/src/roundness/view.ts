import type { View } from "../core/desk";
import { section } from "../core/dom";

export const view: View = {
  id: "roundness",
  title: "Roundness",
  build: (root) => root.append(section("Roundness")),
  state: () => ({}),
  open: async () => {},
};
