/** Bytes as a person writes them: 1.2 MB. */
export function sizeOf(bytes: number): string {
  return inUnits(bytes, 1000, ["B", "kB", "MB", "GB", "TB"]);
}

/** Bytes as an operator sets a limit: 2 GiB. */
export function limitOf(bytes: number): string {
  return inUnits(bytes, 1024, ["B", "KiB", "MiB", "GiB", "TiB"]);
}

function inUnits(bytes: number, base: number, units: string[]): string {
  let value = bytes;
  let k = 0;
  while (value >= base - 0.5 && k < units.length - 1) {
    value /= base;
    k += 1;
  }
  return `${value >= 99.5 || Number.isInteger(value) ? Math.round(value) : value.toFixed(1)} ${units[k]}`;
}

export function count(number: number, noun: string, plural = `${noun}s`): string {
  return `${number} ${number === 1 ? noun : plural}`;
}
