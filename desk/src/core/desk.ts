// Interface between the views and the desk.

import type { Bench } from "./bench";
import type { MachineStore } from "./machine";

/** One page of the desk. */
export interface View {
  id: string;
  title: string;
  /** Builds the view once, when it is first shown. */
  build(root: HTMLElement, desk: Desk): void | Promise<void>;
  /** Called each time the view comes to the front. */
  shown?(): void;
  /** Called when another view comes to the front. */
  hidden?(): void;
  /** State that a link or file keeps to restore the view; JSON. */
  state(): unknown;
  /** Shows a kept state; called after `build`. */
  open(state: unknown): Promise<void>;
}

/** A part program handed from one view to another. */
export interface Program {
  name: string;
  text: string;
}

export interface Desk {
  /** Short requests. */
  bench: Bench;
  /** Runs, in slices. */
  runs: Bench;
  /** Another worker, for a request that can be cancelled by closing it. */
  spare(): Bench;
  machine: MachineStore;
  /** Brings a view to the front. */
  show(id: string): Promise<void>;
  /** Opens a program in the scope and shows it. */
  openProgram(program: Program): Promise<void>;
  onProgram(take: (program: Program) => Promise<void>): void;
  /** Shows a message in the status line. */
  note(text: string): void;
  /** Shows an error with the module's message. */
  fail(error: unknown): void;
  /** Clears the error. */
  clear(): void;
}

/** The text of whatever was thrown. */
export function message(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** Takes the last change of the machine back. */
export function undo({ machine, note }: Desk): void {
  const what = machine.undo();
  if (what !== undefined) note(`${what}: undone`);
}

export function redo({ machine, note }: Desk): void {
  const what = machine.redo();
  if (what !== undefined) note(`${what}: redone`);
}
