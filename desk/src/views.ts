// The views in their groups.

import type { View } from "./core/desk";
import { view as about } from "./about/view";
import { view as ballbar } from "./ballbar/view";
import { view as calibrate } from "./calibrate/view";
import { view as evaluate } from "./evaluate/view";
import { view as friction } from "./friction/view";
import { view as helicoid } from "./helicoid/view";
import { view as keep } from "./keep/view";
import { view as machine } from "./machine/view";
import { view as predict } from "./predict/view";
import { view as roundness } from "./roundness/view";
import { view as scope } from "./scope/view";
import { view as thermal } from "./thermal/view";
import { view as uncertainty } from "./uncertainty/view";

/** The views in the order of the work: what is measured, the machine it makes, the run on it, how it is kept true, and the part. */
export const groups: readonly (readonly [title: string, views: readonly View[]])[] = [
  ["Measure", [ballbar, evaluate, roundness, friction, calibrate]],
  ["Machine", [machine, uncertainty]],
  ["Run", [scope]],
  ["Keep", [thermal, keep]],
  ["Part", [predict, helicoid]],
];
/** The view with which the desk opens. */
export const FIRST = scope.id;
export const views: readonly View[] = [...groups.flatMap(([, own]) => own), about];
