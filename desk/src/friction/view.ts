import type { View } from "../core/desk";
import { section } from "../core/dom";

export const view: View = {
  id: "friction",
  title: "Friction",
  build: (root) => root.append(section("Friction")),
  state: () => ({}),
  open: async () => {},
};
