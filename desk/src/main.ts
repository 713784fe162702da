// The page: starts the module, the views and their shared parts.

import { XzReadableStream } from "xz-decompress";
import "uplot/dist/uPlot.min.css";
import "./style.css";
import { Bench } from "./core/bench";
import { message, undo, type Desk, type Program, type View } from "./core/desk";
import { button, choice, el } from "./core/dom";
import { archive, picker, plain, save, text } from "./core/files";
import { fromBase64, fromLink, link, parse, type SavedPage } from "./core/link";
import { MachineStore } from "./core/machine";
import { setTheme, type Theme } from "./core/theme";
import { FIRST, groups, views } from "./views";

const part = (id: string) => document.getElementById(id) as HTMLElement;

/** The module, from the page's own text: xz in base64. */
async function module(): Promise<WebAssembly.Module> {
  const bytes = fromBase64(part("module").textContent.trim());
  // Compiled while it is unpacked.
  const unpacked = new XzReadableStream(new Blob([bytes]).stream());
  return WebAssembly.compileStreaming(new Response(unpacked, { headers: { "Content-Type": "application/wasm" } }));
}

/** A view with its place on the page. */
class Shown {
  readonly tab: HTMLButtonElement;
  readonly panel: HTMLElement;
  private built: Promise<void> | undefined;

  constructor(
    readonly view: View,
    private readonly desk: Desk,
  ) {
    const { id, title } = view;
    this.panel = el("div", { role: "tabpanel", id: `panel-${id}`, "aria-labelledby": `tab-${id}`, class: `view ${id}`, hidden: true });
    this.tab = button(title, () => void desk.show(id), {
      role: "tab",
      id: `tab-${id}`,
      "aria-controls": `panel-${id}`,
      "aria-selected": "false",
      tabindex: -1,
    });
  }

  /** Builds the view if it has not been yet. */
  build(): Promise<void> {
    if (!this.built) {
      this.panel.setAttribute("aria-busy", "true");
      this.built = Promise.resolve(this.view.build(this.panel, this.desk)).finally(() => this.panel.removeAttribute("aria-busy"));
    }
    return this.built;
  }

  get isBuilt(): boolean {
    return this.built !== undefined;
  }
}

/** The groups of the views; the tabs are those of the group in front. */
class Navigation {
  readonly buttons: HTMLButtonElement[];
  /** The view last shown of each group. */
  private readonly last: string[];

  constructor(
    private readonly shown: readonly Shown[],
    show: (id: string) => void,
  ) {
    this.last = groups.map(([, [view]]) => view!.id);
    this.buttons = groups.map(([title], i) => button(title, () => show(this.last[i]!)));
  }

  /** Shows the place of a view. */
  follow({ view }: Shown): void {
    const own = groups.findIndex(([, views]) => views.includes(view));
    if (own >= 0) this.last[own] = view.id;
    this.buttons.forEach((button, i) => (i === own ? button.setAttribute("aria-current", "true") : button.removeAttribute("aria-current")));
    const tabs = groups[own]?.[1] ?? [view];
    for (const one of this.shown) one.tab.hidden = !tabs.includes(one.view);
  }
}

async function start(): Promise<void> {
  const script = part("worker").textContent;
  const compiled = module();
  const [bench, runs] = [new Bench(compiled, script), new Bench(compiled, script)];
  const machine = new MachineStore();
  const error = part("error");
  let takeProgram: ((program: Program) => Promise<void>) | undefined;

  const desk: Desk = {
    bench,
    runs,
    spare: () => new Bench(compiled, script),
    machine,
    show,
    openProgram: async (program) => {
      await show("scope");
      await takeProgram?.(program);
    },
    onProgram: (take) => (takeProgram = take),
    note: (said) => (part("status").textContent = said),
    fail: (thrown) => {
      error.replaceChildren(el("span", {}, message(thrown)), button("Close", () => desk.clear()));
      error.hidden = false;
    },
    clear: () => {
      error.hidden = true;
      error.replaceChildren();
    },
  };
  for (const worker of [bench, runs])
    worker.onRestart((why) => desk.fail(new Error(`The computation stopped and was restarted: ${why}`)));

  const shown = views.map((view) => new Shown(view, desk));
  const first = shown.find(({ view }) => view.id === FIRST)!;
  let front = first;
  const navigation = new Navigation(shown, (id) => void show(id));

  async function show(id: string): Promise<void> {
    const next = shown.find(({ view }) => view.id === id) ?? first;
    if (front !== next && front.isBuilt) front.view.hidden?.();
    front = next;
    for (const one of shown) {
      const chosen = one === next;
      one.panel.hidden = !chosen;
      one.tab.setAttribute("aria-selected", String(chosen));
      one.tab.tabIndex = chosen ? 0 : -1;
    }
    navigation.follow(next);
    try {
      await next.build();
      // Another view may have come to the front in the meantime.
      if (front === next) next.view.shown?.();
    } catch (thrown) {
      desk.fail(thrown);
    }
  }

  const machineName = el("span", { role: "status" });
  const back = button("Undo", () => undo(desk));
  const files = () => Object.fromEntries(Object.entries(machine.files).map(([name, content]) => [plain(name), content]));
  part("machine").append(machineName, back, button("Save machine", () => save(`${machine.name}.zip`, archive(files()), "application/zip")));
  machine.subscribe(() => {
    const { name, changes, changed, undoable } = machine;
    const many = changes === 1 ? "1 change" : `${changes} changes`;
    machineName.textContent = changes === 0 ? `Machine ${name}, as opened` : `Machine ${name}, ${many} since it was opened`;
    machineName.title = changed.length === 0 ? "" : `Changed: ${changed.join(", ")}`;
    // Not `disabled`, which would lose the keyboard focus.
    back.setAttribute("aria-disabled", String(undoable === undefined));
    back.title = undoable === undefined ? "Nothing to undo" : `Undo: ${undoable}`;
  });
  const tabs = part("tabs");
  part("groups").append(...navigation.buttons);
  tabs.append(...shown.map(({ tab }) => tab));
  part("main").append(...shown.map(({ panel }) => panel));
  tabs.addEventListener("keydown", (event) => {
    const now = shown.indexOf(front);
    const to = { ArrowRight: now + 1, ArrowLeft: now - 1, Home: 0, End: shown.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    const next = shown[(to + shown.length) % shown.length]!;
    void show(next.view.id);
    next.tab.focus();
  });

  const kept = (): SavedPage => ({
    version: 1,
    view: front.view.id,
    machine: { name: machine.name, files: machine.files },
    views: Object.fromEntries(shown.filter((one) => one.isBuilt).map(({ view }) => [view.id, view.state()])),
  });

  async function open(state: SavedPage): Promise<void> {
    // Refused files leave the state unchanged.
    await bench.call("machine_open", JSON.stringify(state.machine.files));
    desk.clear();
    machine.open(state.machine.name, state.machine.files);
    for (const one of shown) {
      if (!(one.view.id in state.views)) continue;
      // A view is built while it is visible, because plots need its width.
      await show(one.view.id);
      try {
        await one.view.open(state.views[one.view.id]);
      } catch (thrown) {
        // The browser does not name a missing part, only the operation that failed.
        throw thrown instanceof TypeError ? new Error(`views.${one.view.id}: found a state with parts missing or of another kind (${message(thrown)}), needed one that this page saved`) : thrown;
      }
    }
    await show(state.view);
  }

  tools(part("tools"), desk, kept, open);
  const sample = JSON.parse(await bench.call("machine_sample", "mill-3axis")) as Record<string, string>;
  machine.open("mill-3axis", sample);
  try {
    const given = await fromLink(location.hash);
    if (given) await open(given);
    else await show(location.hash.slice(1) || front.view.id);
  } catch (thrown) {
    // Starting a view clears errors: report this one afterwards.
    await show(front.view.id);
    desk.fail(thrown);
  }
  part("about").append(button(`About trueaxis ${await bench.call("version")}`, () => void show("about")));
  const root = document.documentElement.dataset;
  root.readyMs = String(Math.round(performance.now()));
  root.ready = "true";
  // For inspection in the browser's console.
  Object.assign(globalThis, { trueaxisDesk: desk });
}

/** Link, file, print, theme. */
function tools(root: HTMLElement, desk: Desk, kept: () => SavedPage, open: (state: SavedPage) => Promise<void>): void {
  const opened = async (json: string | undefined, path: string) => {
    if (json === undefined) throw new Error(`${path}: found bytes that are not UTF-8, needed a file that this page saved`);
    try {
      await open(parse(json));
    } catch (error) {
      throw new Error(`${path}: ${message(error)}`);
    }
  };
  root.append(
    button("Link", () => {
      const made = async () => {
        const address = await link(kept());
        history.replaceState(null, "", address);
        await navigator.clipboard.writeText(address).then(
          () => desk.note(`Link copied, ${address.length} characters; it opens the desk as it is now.`),
          () => desk.note(`The page's address is now the link, ${address.length} characters.`),
        );
      };
      made().catch(desk.fail);
    }),
    button("Save", () => save("trueaxis.desk.json", JSON.stringify(kept(), null, 1), "application/json")),
    picker("Open", { accept: ".json" }, ([file]) => file && opened(text(file.bytes), file.path).catch(desk.fail), desk.fail),
    button("Print", () => print()),
    choice<Theme>("Theme", [["system", "as the system"], ["light", "light"], ["dark", "dark"]], "system", setTheme).root,
  );
}

start().catch((error: unknown) => {
  part("error").textContent = `The desk cannot start: ${message(error)}. Needed: a browser with WebAssembly and DecompressionStream.`;
  part("error").hidden = false;
});
