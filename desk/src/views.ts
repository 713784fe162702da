// The views, in the order of their tabs.

import type { View } from "./core/desk";
import { view as about } from "./about/view";
import { view as ballbar } from "./ballbar/view";
import { view as calibrate } from "./calibrate/view";
import { view as evaluate } from "./evaluate/view";
import { view as friction } from "./friction/view";
import { view as helicoid } from "./helicoid/view";
import { view as keep } from "./keep/view";
import { view as machine } from "./machine/view";
import { view as roundness } from "./roundness/view";
import { view as scope } from "./scope/view";
import { view as thermal } from "./thermal/view";
import { view as uncertainty } from "./uncertainty/view";

export const views: View[] = [machine, scope, helicoid, roundness, calibrate, keep, ballbar, evaluate, thermal, friction, uncertainty, about];
