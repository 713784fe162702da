// The machine as files, and the equivalent command lines.

import type { Desk } from "../core/desk";
import { button, commandLine, el, section } from "../core/dom";
import { plain, save } from "../core/files";
import { word } from "../core/shell";
import type { Editor } from "./editor";

export function exporting(desk: Desk, editor: Editor): HTMLElement {
  const files = el("div", { class: "row tight" });
  const check = commandLine("As on the command line, with the files saved");
  const compile = commandLine("compiled");
  const accuracy = commandLine("accuracy");
  const one = (name: string) => save(plain(name), desk.machine.files[name] ?? "", name.endsWith(".csv") ? "text/csv;charset=utf-8" : undefined);

  const tcomp = async () => {
    const bytes = await desk.bench.call("machine_to_tcomp", desk.machine.json, editor.rate_hz);
    save(`${desk.machine.name}.tcomp`, new Uint8Array(bytes), "application/octet-stream");
  };
  editor.subscribe(() => {
    const { name } = desk.machine;
    const folder = word(name);
    const rate = editor.rate_hz === 10_000 ? "" : ` --rate-hz ${editor.rate_hz}`;
    files.replaceChildren(...Object.keys(desk.machine.files).map((file) => button(`Save ${file}`, () => one(file))));
    check.set(`trueaxis tables check ${folder}${rate}`);
    compile.set(`trueaxis tables compile ${folder}${rate} -o ${folder}.tcomp`);
    const measured = editor.shown?.measurements.find(({ figures }) => figures);
    accuracy.root.hidden = !measured;
    accuracy.set(measured ? `trueaxis tables accuracy ${folder}/${measured.file} --machine ${folder}` : "");
  });
  return section(
    "Export",
    el(
      "div",
      { class: "row tight" },
      button("Save .tcomp", () => void tcomp().catch(desk.fail), { class: "primary" }),
      button("Save all files", () => Object.keys(desk.machine.files).forEach(one)),
      button("Run with these tables", () => void desk.show("scope")),
    ),
    files,
    check.root,
    compile.root,
    accuracy.root,
  );
}
