import type { View } from "../core/desk";
import { section } from "../core/dom";

export const view: View = {
  id: "scope",
  title: "Servo scope",
  build: (root) => root.append(section("Servo scope")),
  state: () => ({}),
  open: async () => {},
};
