// Opening a machine: a sample, a folder, files, a drop.

import type { Desk } from "../core/desk";
import { choice, el } from "../core/dom";
import { onDrop, packed, picker, type Given } from "../core/files";
import type { Files } from "../core/machine";
import type { Editor } from "./editor";

interface Taken {
  name: string;
  files: Files;
  notes: string[];
}

interface Sample {
  name: string;
  description: string;
}

export async function opening(root: HTMLElement, desk: Desk, editor: Editor): Promise<HTMLElement> {
  const notes = el("span", { class: "said", role: "status" });

  const take = async (given: Given[]) => {
    // Files without a machine description are added to the current machine.
    const taken = JSON.parse(await desk.bench.call("machine_from_files", desk.machine.json, ...packed(given))) as Taken;
    const joins = !given.some(({ path }) => /\.(toml|tcomp)$/i.test(path));
    await editor.load(joins ? desk.machine.name : taken.name, taken.files, `opened ${given.length === 1 ? given[0]?.path : taken.name}`);
    notes.textContent = taken.notes.join("; ");
  };
  const taking = (given: Given[]) => void take(given).catch(desk.fail);

  const samples = JSON.parse(await desk.bench.call("machine_samples")) as Sample[];
  const names = samples.map(({ name }) => [name, name] as const);
  const described = el("span", { class: "said" });
  const describe = () => {
    const sample = samples.find(({ name }) => name === desk.machine.name);
    described.textContent = sample ? `${sample.description}.` : "";
  };
  const sample = choice("Sample machine", [["", "choose…"], ...names], "", (name) => {
    if (name === "") return;
    const load = async () => {
      const files = JSON.parse(await desk.bench.call("machine_sample", name)) as Files;
      await editor.load(name, files, `opened the sample ${name}`);
      notes.textContent = "";
    };
    load().catch(desk.fail);
  });
  const follow = () => {
    sample.value = samples.some(({ name }) => name === desk.machine.name) ? desk.machine.name : "";
    describe();
  };
  desk.machine.subscribe(follow);
  follow();

  onDrop(root, taking, desk.fail);
  return el(
    "div",
    { class: "row" },
    sample.root,
    picker("Open a folder…", { folder: true, several: true }, taking, desk.fail),
    picker("Open files or a .tcomp…", { several: true, accept: ".toml,.csv,.tcomp" }, taking, desk.fail),
    el("span", { class: "said" }, "or drop them here"),
    described,
    notes,
  );
}
