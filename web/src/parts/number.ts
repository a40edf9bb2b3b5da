/** Figures as a person reads them. */

export const NO_VALUE = "–";

/** `digits` significant digits, a real minus sign, no needless zeros; very large or small ones with a power of ten. */
export function figure(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return NO_VALUE;
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) {
    const [head, power] = value.toExponential(Math.max(digits - 2, 0)).split("e");
    return minus(`${Number(head)}·10${superscript(Number(power))}`);
  }
  return minus(String(Number(value.toPrecision(digits))));
}

/** Always that many decimals. */
export function fixed(value: number | null | undefined, decimals: number): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return NO_VALUE;
  const text = value.toFixed(decimals);
  return minus(Number(text) === 0 ? (0).toFixed(decimals) : text);
}

const NEGLIGIBLE = 1e-5;

/** The value with as many decimals as its standard deviation has two digits of: 197.8 ± 0.6; alone where that is
nothing beside it. */
export function withStd(value: number | null | undefined, std: number | null | undefined): string {
  if (std === null || std === undefined || !(std > 0) || value === null || value === undefined || std < NEGLIGIBLE * Math.abs(value)) {
    return figure(value);
  }
  const decimals = Math.min(Math.max(1 - Math.floor(Math.log10(std)), 0), 8);
  return `${fixed(value, decimals)} ± ${fixed(std, decimals)}`;
}

function minus(text: string): string {
  return text.replace("-", "−");
}

function superscript(power: number): string {
  const signs = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  return String(power)
    .replace("-", "⁻")
    .replace(/\d/g, (digit) => signs[Number(digit)] ?? "");
}
