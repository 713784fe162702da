import type { View } from "../core/desk";
import { section } from "../core/dom";

export const view: View = {
  id: "machine",
  title: "Machine",
  build: (root) => root.append(section("Machine")),
  state: () => ({}),
  open: async () => {},
};
