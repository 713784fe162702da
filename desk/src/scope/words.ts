// Acts and faults as a person names them.

/** Faults of the step (`trueaxis::Fault`) by their codes; with an axis, its name stands in front. */
const FAULTS: Record<string, string> = {
  FeedbackNotFinite: "encoder not a number",
  FeedbackJump: "encoder jumps",
  EncoderStuck: "encoder stuck",
  EncoderAlarm: "encoder alarm",
  LateCycle: "cycle late or early",
  FeedbackRatio: "encoder of wrong sign or scale",
  StickSlip: "sticks and slips, its friction as identified again",
  FrictionReversed: "friction of wrong sign, as identified again",
  CommandNotFinite: "command not a number",
  CommandOutOfTravel: "command outside the travel",
  CommandJump: "command jumps",
  JointRange: "correction leaves the joint's range",
  ToolUnreachable: "tool tip out of reach",
  SingularPose: "near the singular pose",
  BranchChange: "rotary axes would have to swing over",
  PeriodMismatch: "servo period not the configured one",
  TablesRefused: "tables refused",
  CapacityTooSmall: "tables too large for the memory",
  AbiMismatch: "host and plugin of different versions",
};

export function faultInWords(code: string, axis: string): string {
  const letter = /^[XYZABC]$/.test(axis) ? `${axis} ` : "";
  return `${letter}${FAULTS[code] ?? code}`;
}

/** Faults that can be injected. */
const INJECTED: Record<string, string> = {
  dropout: "reading missing",
  glitch: "reading off",
  stuck: "reading stuck",
  scale: "reading of wrong scale",
  late: "cycle late",
  "nan-command": "command not a number",
  "jump-command": "command jumps",
};

/** Parts that can be switched, by their names in the scenario file. */
export const SWITCHES: readonly (readonly [string, string])[] = [
  ["correction", "Correction"],
  ["friction", "Friction"],
  ["lag", "Lag"],
  ["acceleration", "Acceleration"],
  ["feedback", "Contour feedback"],
  ["take-up", "Take-up"],
  ["crosstalk", "Cross-talk"],
  ["trial", "On trial"],
];

/** A kind of fault that can be injected. */
export function injected(kind: string): string {
  return INJECTED[kind] ?? kind;
}

/** An act of a scenario file in a few words, without its time. */
export function actInWords(act: string): string {
  const [, kind = "", of = ""] = /^\s*([\w-]+)(?::(.*))?@[^@]*$/.exec(act) ?? [];
  if (kind === "exchange") return `tables ${of}`;
  if (kind === "on" || kind === "off") return `${SWITCHES.find(([name]) => name === of)?.[1] ?? of} ${kind}`;
  return kind === "" ? act : `${of ? `${of} ` : ""}${injected(kind)}`;
}
