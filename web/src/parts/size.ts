/** Bytes as a person writes them: 1.2 MB, and GiB as a limit is set. */
export function sizeOf(bytes: number): string {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let value = bytes;
  let k = 0;
  while (value >= 999.5 && k < units.length - 1) {
    value /= 1000;
    k += 1;
  }
  return `${k === 0 || value >= 99.5 ? Math.round(value) : value.toFixed(1)} ${units[k]}`;
}

export function count(number: number, noun: string, plural = `${noun}s`): string {
  return `${number} ${number === 1 ? noun : plural}`;
}
