// The views, in the order of their tabs.

import type { View } from "./core/desk";
import { view as ballbar } from "./ballbar/view";
import { view as friction } from "./friction/view";
import { view as helicoid } from "./helicoid/view";
import { view as machine } from "./machine/view";
import { view as roundness } from "./roundness/view";
import { view as scope } from "./scope/view";

export const views: View[] = [machine, scope, helicoid, roundness, ballbar, friction];
