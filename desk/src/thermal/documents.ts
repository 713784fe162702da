// The module's response: tables, plots, the texts.

import type { Shown } from "../core/shown-types";

export interface Fitted {
  shown: Shown;
  toml: string;
  notes: string[];
}
