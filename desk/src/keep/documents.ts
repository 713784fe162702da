// The module's responses: tables, the history, the updated machine.

import type { Becomes } from "../core/becomes";
import type { Shown, Table } from "../core/shown-types";

export interface Evaluated {
  shown: Shown;
  machine: string;
  entry: number;
  touches: number;
  refusal: string | null;
  becomes: Becomes | null;
  entries: Table;
  written: [name: string, text: string][];
  history: string;
  notes: string[];
}
