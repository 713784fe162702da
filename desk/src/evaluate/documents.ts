// The module's response: the contents of the command line's report page.

import type { Becomes } from "../core/becomes";
import type { Shown } from "../core/shown-types";

export type Test = "step-diagonal" | "r-test" | "points" | "probing" | "thermal";

export interface Evaluated {
  shown: Shown;
  becomes: Becomes | null;
  notes: string[];
}
