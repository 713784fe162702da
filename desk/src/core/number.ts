// Number formatting.

/** A number with `digits` significant digits, without an exponent between 1e-4 and 1e6. */
export function significant(value: number, digits: number): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e6) return value.toExponential(digits - 1).replace("-", "−").replace("e+", "e");
  const places = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return minus(value.toFixed(Math.min(places, 12)));
}

/** A number with `decimals` decimals. */
export function fixed(value: number, decimals: number): string {
  return Number.isFinite(value) ? minus(value.toFixed(decimals)) : "–";
}

/** A table cell with fixed decimals that keeps the number at full precision. */
export function cell(value: number | null | undefined, decimals = 3): { text: string; value: number } | string {
  return value === null || value === undefined ? "–" : { text: fixed(value, decimals), value };
}

/** A table cell with significant digits that keeps the number at full precision. */
export function shown(value: number, digits = 3): { text: string; value: number } {
  return { text: significant(value, digits), value };
}

/** A value rounded to the place of the second digit of its expanded uncertainty, or to four digits if that is not known. */
export function asFarAs(value: number, half: number): string {
  if (!(half > 0 && Number.isFinite(half))) return significant(value, 4);
  const decimals = 1 - Math.floor(Math.log10(Number(half.toPrecision(2))));
  const place = 10 ** -decimals;
  return decimals >= 0 ? fixed(value, Math.min(decimals, 12)) : fixed(Math.round(value / place) * place, 0);
}

function minus(text: string): string {
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}
