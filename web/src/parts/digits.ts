/** How many digits a number deserves: two of its standard deviation, and the value to the same place.

The rules are those of the report: `server/exogauge/studies/words/rounding.py`.
*/

export const NONE = "–";
const SURE = 1e-5;

/** Rounded to so many digits; powers of ten only outside 1e-4 … 1e5. */
export function significant(value: number | null | undefined, digits = 3): string {
  if (!isNumber(value)) return NONE;
  if (value === 0) return "0";
  const [mantissa = "", power = "0"] = value.toExponential(digits - 1).split("e");
  const exponent = Number(power);
  if (exponent < -4 || exponent >= 5) return `${minus(mantissa)}·10${raised(exponent)}`;
  return fixed(value, Math.max(digits - 1 - exponent, 0));
}

/** [value, std] as text, the value to the place of the std's second digit: 5.0316, 0.0412 -> 5.032, 0.041.

A std that would show only beyond the value's fifth digit is none.
*/
export function withStd(value: number | null | undefined, std: number | null | undefined): [string, string] {
  if (!isNumber(value)) return [NONE, NONE];
  if (!isNumber(std) || std <= Math.abs(value) * SURE) return [significant(value, 4), NONE];
  let place = 1 - Math.floor(Math.log10(std));
  if (Math.round(std * 10 ** place) >= 100) place -= 1; // 0.0998 rounds to 0.10
  if (place > 6) return [significant(value, 4), significant(std, 2)];
  return [fixed(value, place), fixed(std, place)];
}

/** The two as one text: 5.032 ± 0.041; the value alone, as `figure` writes it, where it has no std. */
export function plusMinus(value: number | null | undefined, std: number | null | undefined): string {
  const [shown, doubt] = withStd(value, std);
  return doubt === NONE ? figure(value) : `${shown} ± ${doubt}`;
}

/** What somebody chose or wrote: at most so many digits, and no needless zeros. */
export function figure(value: number | null | undefined, digits = 4): string {
  return significant(value, digits).replace(/(\.\d*?)0+(?=·|$)/, "$1").replace(/\.(?=·|$)/, "");
}

/** An interval, both ends to the place of its half width's second digit: 190.71, 200.93 -> 190.7 … 200.9. */
export function between([low, high]: (number | null)[]): string {
  if (!isNumber(low) || !isNumber(high) || high <= low) return "no bounds";
  const place = Math.max(0, 1 - Math.floor(Math.log10(0.5 * (high - low))));
  return `${fixed(low, place)} … ${fixed(high, place)}`;
}

/** To so many places; a negative number of them rounds to tens, hundreds. */
export function fixed(value: number | null | undefined, places: number): string {
  if (!isNumber(value)) return NONE;
  const step = 10 ** Math.max(-places, 0);
  const rounded = step > 1 ? Math.round(value / step) * step : value;
  return minus(rounded.toFixed(Math.max(places, 0)));
}

export function percent(share: number | null | undefined, digits = 0): string {
  return isNumber(share) ? `${fixed(100 * share, digits)} %` : NONE;
}

/** As results.json writes units, without the one that says there is none. */
export function unitOf(unit: string | null | undefined): string {
  return unit === "1" || !unit ? "" : unit;
}

export function isNumber(value: unknown): value is number {
  return typeof value === "number" && Number.isFinite(value);
}

/** A true minus sign, and none before a zero. */
function minus(text: string): string {
  return /^-[0.]*$/.test(text) ? text.slice(1) : text.replace("-", "−");
}

function raised(power: number): string {
  return [...String(power)].map((sign) => (sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(sign)])).join("");
}
