// The module's documents, as printed by the command line.

import type { Shown, Table } from "../core/shown-types";

export interface Probes {
  n: number;
  harmonics?: [number, number];
  p?: number;
  q?: number;
  phi2_deg?: number;
  phi3_deg?: number;
}

export interface Request {
  probes: Probes;
  arm?: [number, number, number];
  upr?: number;
  noise_gain_limit: number;
}

export const CIRCLES = ["lsc", "mzc", "mic", "mcc"] as const;
export type CircleName = (typeof CIRCLES)[number];

export const CIRCLE_WORDS: Record<CircleName, string> = {
  lsc: "LSC, least squares",
  mzc: "MZC, minimum zone",
  mic: "MIC, maximum inscribed",
  mcc: "MCC, minimum circumscribed",
};

/** Tables and plots of an evaluation, its warnings, and the command line's notes. */
export interface Noted {
  warnings: string[];
  shown: Shown;
  notes: string[];
}

export interface Pair {
  p?: number;
  q?: number;
  phi2_deg: number;
  phi3_deg: number;
  worst_gain: number;
  worst_noise_gain: number;
  worst_harmonic: number;
}

export interface Curve {
  n: number;
  phi2_deg: number;
  phi3_deg: number;
  worst: Pair | null;
  noise_gains: { k: number; noise_gain: number }[];
  singular: number[];
  blind: number[];
}

export interface Best {
  best: Pair[];
  table: Table;
}

/** Options of a command line for these probes. */
export function probeOptions(probes: Probes): string[] {
  const { n, harmonics, p, q, phi2_deg, phi3_deg } = probes;
  const angles = p !== undefined ? ["--p", p, "--q", q] : phi2_deg !== undefined ? ["--phi2-deg", phi2_deg, "--phi3-deg", phi3_deg] : [];
  const band = harmonics ? ["--harmonics", harmonics.join("..")] : [];
  return ["--n", n, ...angles, ...band].map(String);
}

/** "4", "4 and 9", "4, 9 and 12". */
export function listed(numbers: readonly number[]): string {
  if (numbers.length < 2) return numbers.join("");
  return `${numbers.slice(0, -1).join(", ")} and ${numbers[numbers.length - 1]}`;
}
