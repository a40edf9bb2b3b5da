/** The path, or where a file has it already (in whatever capitals) the next free one: run.csv, run-2.csv, … */
export function freePath(path: string, taken: readonly string[]): string {
  const there = new Set(taken.map((each) => each.toLowerCase()));
  if (!there.has(path.toLowerCase())) return path;
  const name = path.lastIndexOf("/") + 1;
  const dot = path.indexOf(".", name + 1);
  const [stem, ending] = dot < 0 ? [path, ""] : [path.slice(0, dot), path.slice(dot)];
  for (let k = 2; ; k++) if (!there.has(`${stem}-${k}${ending}`.toLowerCase())) return `${stem}-${k}${ending}`;
}
