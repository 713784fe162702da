import type { View } from "../core/desk";
import { section } from "../core/dom";

export const view: View = {
  id: "helicoid",
  title: "Helicoid and five axes",
  build: (root) => root.append(section("Helicoid and five axes")),
  state: () => ({}),
  open: async () => {},
};
