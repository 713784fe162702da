// Light and dark themes, and curve colours that remain distinguishable by lightness and for the colour-blind.

/** After the palette of Okabe and Ito (jfly.uni-koeln.de/color), darkened on white and lightened on black. */
const COLOURS = {
  ink: ["#1f2328", "#e6e8eb"],
  grid: ["#e4e7eb", "#2c323a"],
  paper: ["#ffffff", "#14171b"],
  before: ["#b84a00", "#f0a36a"],
  after: ["#005a9c", "#6db3f2"],
  servo: ["#5f6670", "#a4abb5"],
  full: ["#00725a", "#46c7a0"],
  x: ["#b84a00", "#f0a36a"],
  y: ["#00725a", "#46c7a0"],
  z: ["#005a9c", "#6db3f2"],
  a: ["#8c3b74", "#dd8fc2"],
  b: ["#8a6d00", "#e3c44c"],
  c: ["#4b4a9e", "#a9a8ee"],
  measured: ["#1f2328", "#e6e8eb"],
  warning: ["#a40e26", "#ff8f8f"],
} as const;

export type ColourName = keyof typeof COLOURS;

const query = matchMedia("(prefers-color-scheme: dark)");
/** Weak references, so that removed plots and pictures are collected. */
const listeners = new Set<{ owner: WeakRef<object>; listener: (owner: never) => void }>();

export type Theme = "system" | "light" | "dark";

function dark(): boolean {
  const chosen = document.documentElement.dataset.theme as Theme | undefined;
  return chosen === "dark" || (chosen !== "light" && query.matches);
}

/** A colour of the present theme. */
export function colour(name: ColourName): string {
  return COLOURS[name][dark() ? 1 : 0];
}

/** A colour of the present theme as red, green and blue from 0 to 1. */
export function rgb(name: ColourName): [number, number, number] {
  const value = Number.parseInt(colour(name).slice(1), 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

/** Called whenever the colours change, as long as the owner is in use; `listener` must not keep a reference to it. */
export function onTheme<T extends object>(owner: T, listener: (owner: T) => void): void {
  listeners.add({ owner: new WeakRef(owner), listener });
}

function apply(): void {
  const style = document.documentElement.style;
  for (const name of Object.keys(COLOURS) as ColourName[]) style.setProperty(`--${name}`, colour(name));
  style.colorScheme = dark() ? "dark" : "light";
  for (const one of listeners) {
    const owner = one.owner.deref();
    if (owner) one.listener(owner as never);
    else listeners.delete(one);
  }
}

/** Light, dark, or as the system has it. */
export function setTheme(theme: Theme): void {
  document.documentElement.dataset.theme = theme;
  apply();
}

query.addEventListener("change", apply);
apply();

type Colour = readonly [number, number, number];

/**
 * Errors from none to the largest: from blue to red on a light page, from blue to yellow on a dark one. The larger the error, the
 * further its lightness is from that of the page, so that the scale reads without colour; even the smallest has a contrast of 3.
 */
const SCALE: readonly [light: readonly Colour[], dark: readonly Colour[]] = [
  [[75, 147, 189], [96, 113, 178], [136, 66, 134], [140, 26, 66], [84, 4, 16]],
  [[79, 127, 181], [152, 138, 200], [222, 150, 164], [246, 190, 120], [255, 233, 168]],
];

/** Colour of an error from 0 to 1, as red, green and blue from 0 to 1. */
export function scale(size: number): [number, number, number] {
  const stops = SCALE[dark() ? 1 : 0];
  const at = Math.min(1, Math.max(0, size)) * (stops.length - 1);
  const low = Math.min(stops.length - 2, Math.floor(at));
  const [one, next] = [stops[low]!, stops[low + 1]!];
  return [0, 1, 2].map((k) => (one[k]! + (next[k]! - one[k]!) * (at - low)) / 255) as [number, number, number];
}

/** Black or white, whichever is easier to read on a colour (WCAG 2.2, relative luminance). */
export function inkOn(colour: readonly number[]): "#000" | "#fff" {
  const [red, green, blue] = colour.map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4)) as [number, number, number];
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.179 ? "#000" : "#fff";
}
