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

/** Sizes from 0 to 1 as colours that grow evenly lighter (cividis, Nuñez et al., 10.1371/journal.pone.0199239). */
const SCALE: ReadonlyArray<readonly [number, number, number]> = [
  [0.0, 0.135, 0.305],
  [0.165, 0.253, 0.43],
  [0.315, 0.363, 0.427],
  [0.448, 0.475, 0.461],
  [0.585, 0.589, 0.465],
  [0.735, 0.712, 0.421],
  [0.886, 0.843, 0.336],
  [0.995, 0.909, 0.217],
];

/** Colour of a size from 0 to 1; reversed in the light theme, in which the darkest is the largest. */
export function scale(size: number): [number, number, number] {
  const clamped = Math.min(1, Math.max(0, size));
  const at = (dark() ? clamped : 1 - clamped) * (SCALE.length - 1);
  const low = Math.min(SCALE.length - 2, Math.floor(at));
  const [one, next] = [SCALE[low]!, SCALE[low + 1]!];
  return [0, 1, 2].map((k) => one[k]! + (next[k]! - one[k]!) * (at - low)) as [number, number, number];
}
