// Information about the page, and the licences of its contents.

import licences from "../../../crates/trueaxis-cli/THIRD-PARTY.txt";
import type { View } from "../core/desk";
import { el } from "../core/dom";

export const view: View = {
  id: "about",
  title: "About",
  build: (root) => {
    root.append(
      el("p", {}, "The desk is one file. It runs the crates of trueaxis in your browser; what you open stays on your computer."),
      el("h2", {}, "Licences"),
      el("pre", { tabindex: 0, "aria-label": "Licences" }, licences),
    );
  },
  state: () => null,
  open: () => Promise.resolve(),
};
