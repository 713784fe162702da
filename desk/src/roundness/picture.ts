// Figures drawn by the module, and a picture of the probes around the part.

import type { ColourName } from "../core/theme";

/** Colours of the reports as those of the page, which follow the theme. */
const COLOURS: Record<string, ColourName> = {
  "1F2328": "measured",
  "5F6670": "servo",
  "868C95": "servo",
  B84A00: "before",
  "005A9C": "after",
  "00725A": "full",
  "4B4A9E": "c",
  "8C3B74": "a",
  A40E26: "warning",
  E4E7EB: "grid",
  "787E87": "servo",
  FFFFFF: "paper",
};

/** A figure's HTML in the page's colours. */
export function themed(html: string): string {
  return html.replace(/#([0-9A-F]{6})\b/gi, (whole, hex: string) => {
    const name = COLOURS[hex.toUpperCase()];
    return name ? `var(--${name})` : whole;
  });
}

const SVG = "http://www.w3.org/2000/svg";

function shape(name: string, attributes: Record<string, string | number>, text?: string): SVGElement {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  if (text !== undefined) element.textContent = text;
  return element;
}

/** Three probes round a part, seen along its axis: 0° to the right, counter-clockwise. */
export function arrangement(phi2_deg: number, phi3_deg: number): SVGElement {
  const at = [0, phi2_deg, phi2_deg + phi3_deg];
  const said = at.map((angle, i) => `probe ${i + 1} at ${(((angle % 360) + 360) % 360).toFixed(2)}°`).join(", ");
  const svg = shape("svg", { viewBox: "-125 -125 250 250", role: "img", "aria-label": `Part with ${said}`, class: "arrangement" });
  svg.append(shape("circle", { r: 52, class: "part" }), shape("path", { d: "M-6 0H6M0 -6V6", class: "mark" }));
  at.forEach((angle, i) => {
    const [c, s] = [Math.cos((angle * Math.PI) / 180), -Math.sin((angle * Math.PI) / 180)];
    const group = shape("g", { transform: `rotate(${-angle})`, class: `probe probe-${i + 1}` });
    group.append(shape("path", { d: "M53 0L63 -3.5V3.5Z", class: "tip" }), shape("rect", { x: 63, y: -6, width: 30, height: 12, rx: 2 }));
    svg.append(group, shape("text", { x: 108 * c, y: 108 * s + 4, "text-anchor": "middle" }, String(i + 1)));
  });
  const arc = (from: number, by: number, r: number) => {
    const turn = ((by % 360) + 360) % 360;
    const end = (angle: number) => `${r * Math.cos((angle * Math.PI) / 180)} ${-r * Math.sin((angle * Math.PI) / 180)}`;
    return `M${end(from)}A${r} ${r} 0 ${turn > 180 ? 1 : 0} 0 ${end(from + turn)}`;
  };
  const middle = (from: number, by: number, r: number) => {
    const angle = ((from + (((by % 360) + 360) % 360) / 2) * Math.PI) / 180;
    return { x: r * Math.cos(angle), y: -r * Math.sin(angle) + 4, "text-anchor": "middle", class: "small" };
  };
  svg.append(shape("path", { d: arc(0, phi2_deg, 40), class: "arc" }), shape("path", { d: arc(phi2_deg, phi3_deg, 32), class: "arc other" }));
  svg.append(shape("text", middle(0, phi2_deg, 26), "φ2"), shape("text", middle(phi2_deg, phi3_deg, 18), "φ3"));
  return svg;
}
