// The text of a part program with the current line marked; only the visible lines of a long program are drawn.

import { el, unique } from "../core/dom";

/** Height of a line, px; also in scope.css. */
const HEIGHT = 18;
/** Lines drawn beyond either edge. */
const MARGIN = 12;

export class Listing {
  readonly root: HTMLElement;
  private readonly box: HTMLElement;
  private readonly sheet: HTMLElement;
  private readonly prefix = unique("line");
  private lines: string[] = [];
  private running = 0;
  private chosen = 0;

  /** `chose` receives the line, from 1, selected by click or by keys. */
  constructor(private readonly chose: (line: number) => void) {
    this.sheet = el("div", { class: "sheet", role: "presentation" });
    this.box = el(
      "div",
      {
        class: "listing",
        role: "listbox",
        tabindex: 0,
        "aria-label": "Part program",
        onkeydown: (event: KeyboardEvent) => this.key(event),
        onscroll: () => this.draw(),
        onclick: (event: MouseEvent) => this.clicked(event),
      },
      this.sheet,
    );
    this.root = this.box;
    new ResizeObserver(() => this.draw()).observe(this.box);
  }

  set(lines: readonly string[]): void {
    this.lines = [...lines];
    this.running = this.chosen = 0;
    this.sheet.style.height = `${this.lines.length * HEIGHT}px`;
    this.box.scrollTop = 0;
    this.draw();
  }

  /** Marks the line being run, and brings it into sight. */
  run(line: number): void {
    if (line === this.running) return;
    this.running = line;
    this.into(line);
    this.draw();
  }

  private into(line: number): void {
    const [top, height] = [(line - 1) * HEIGHT, this.box.clientHeight];
    const out = top < this.box.scrollTop + HEIGHT || top > this.box.scrollTop + height - 2 * HEIGHT;
    if (line > 0 && out) this.box.scrollTop = Math.max(0, top - height / 2);
  }

  private choose(line: number): void {
    this.chosen = Math.min(this.lines.length, Math.max(1, line));
    this.into(this.chosen);
    this.draw();
    this.chose(this.chosen);
  }

  private clicked(event: MouseEvent): void {
    const line = (event.target as HTMLElement).closest<HTMLElement>("[data-line]")?.dataset.line;
    if (line) this.choose(Number(line));
  }

  private key(event: KeyboardEvent): void {
    const now = this.chosen || this.running;
    const page = Math.max(1, Math.floor(this.box.clientHeight / HEIGHT) - 1);
    const steps: Record<string, number> = { ArrowDown: now + 1, ArrowUp: now - 1, PageDown: now + page, PageUp: now - page, Home: 1, End: this.lines.length };
    const to = steps[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.choose(to);
  }

  private draw(): void {
    const first = Math.max(0, Math.floor(this.box.scrollTop / HEIGHT) - MARGIN);
    const last = Math.min(this.lines.length, Math.ceil((this.box.scrollTop + this.box.clientHeight) / HEIGHT) + MARGIN);
    const shown: HTMLElement[] = [];
    for (let i = first; i < last; i++) shown.push(this.line(i + 1));
    this.sheet.replaceChildren(...shown);
    const active = this.chosen || this.running;
    if (active > first && active <= last) this.box.setAttribute("aria-activedescendant", `${this.prefix}-${active}`);
    else this.box.removeAttribute("aria-activedescendant");
  }

  private line(number: number): HTMLElement {
    return el(
      "div",
      {
        id: `${this.prefix}-${number}`,
        role: "option",
        class: "line",
        "data-line": number,
        "aria-selected": String(number === this.chosen),
        "aria-current": number === this.running ? "step" : undefined,
        "aria-posinset": number,
        "aria-setsize": this.lines.length,
        style: `top:${(number - 1) * HEIGHT}px`,
      },
      el("span", { class: "at" }, String(number)),
      this.lines[number - 1] || " ",
    );
  }
}
