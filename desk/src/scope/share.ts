// A scenario for sharing: the command line that reproduces it, and its files.

import type { Desk } from "../core/desk";
import { button, commandLine, el, section } from "../core/dom";
import { archive, save } from "../core/files";
import type { Scenario } from "./documents";

export class Share {
  readonly root: HTMLElement;
  private readonly command = commandLine("The same run:");

  constructor(desk: Desk, scenario: () => Promise<Scenario>) {
    const saving = (save: (scenario: Scenario) => void) => () => void scenario().then(save).catch(desk.fail);
    const files = button(
      "Save files (ZIP)",
      saving(({ files, command }) => save("scenario.zip", archive({ ...files, "command.txt": `${command}\n` }), "application/zip")),
    );
    const toml = button("Save settings (TOML)", saving((scenario) => save("scenario.toml", scenario.toml, "application/toml")));
    const hint = "Unpack the files and give the command in their folder: the same figures and the same digest. Link and Save, at the top of the page, keep machine, program, settings and acts for this page.";
    this.root = section("Scenario", this.command.root, el("div", { class: "row" }, files, toml), el("p", { class: "note" }, hint));
  }

  set(scenario: Scenario): void {
    this.command.set(scenario.command);
  }
}
