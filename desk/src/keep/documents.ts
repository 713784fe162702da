// The module's responses: the command line's documents, verdicts and entries in words, the updated machine.

import type { Becomes } from "../core/becomes";

interface Term {
  name: string;
  unit: string;
  value: number;
  standard_error: number;
  from: number;
  to: number;
  largest_update: number;
  largest_total: number;
  significance: number;
}

export interface Evaluated {
  document: {
    machine: string;
    entry: number;
    touches: number;
    sigma_um: number;
    terms: Term[];
    balls: { name: string; centre_mm: [number, number, number]; standard_error_um: [number, number, number] }[];
    notes: string[];
  };
  verdicts: string[];
  refusal: string | null;
  becomes: Becomes | null;
  entries: { entry: number; time: string | null; parts: number | null; deed: string; changed: string[] }[];
  written: [name: string, text: string][];
  history: string;
  notes: string[];
}
