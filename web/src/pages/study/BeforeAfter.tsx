import { significant, isNumber } from "../../parts/digits";
import styles from "./BeforeAfter.module.css";
import type { Num } from "./results";

/** sort: rows of one unit and sort share a scale. steady: after, in steady motion alone. */
export type ErrorRow = { name: string; before: Num; after: Num; steady?: Num; floor: Num; unit: string; sort?: string };

/** Two bars per row, or three, with a tick where the noise is. */
export function BeforeAfter({ name, rows }: { name: string; rows: ErrorRow[] }) {
  const longest = new Map<string, number>();
  for (const row of rows) {
    const values = [row.before, row.after, row.steady, row.floor].filter(isNumber);
    longest.set(scaleOf(row), Math.max(longest.get(scaleOf(row)) ?? 0, ...values));
  }
  return (
    <>
      <p className={styles.key} aria-hidden>
        <span data-part="before" className={styles.swatch} /> before
        <span data-part="after" className={styles.swatch} /> after
        {rows.some(({ steady }) => isNumber(steady)) && (
          <>
            <span data-part="steady" className={styles.swatch} /> after, in steady motion
          </>
        )}
        <span data-part="floor" className={styles.swatch} /> noise floor
      </p>
      <table className={styles.table}>
        <caption className={styles.hidden}>{name}</caption>
        <thead className={styles.hidden}>
          <tr>
            <th scope="col">What</th>
            <th scope="col">Error</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <tr key={row.name} className={styles.row}>
              <th scope="row" className={styles.name}>
                {row.name}
              </th>
              <td className={styles.cell}>
                <Bar part="before" words="before" row={row} value={row.before} end={longest.get(scaleOf(row)) ?? 1} />
                <Bar part="after" words="after" row={row} value={row.after} end={longest.get(scaleOf(row)) ?? 1} />
                {isNumber(row.steady) && (
                  <Bar part="steady" words="after, in steady motion" row={row} value={row.steady} end={longest.get(scaleOf(row)) ?? 1} />
                )}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

function scaleOf({ unit, sort = "" }: ErrorRow): string {
  return `${unit} ${sort}`;
}

type BarProps = { part: string; words: string; row: ErrorRow; value: Num; end: number };

function Bar({ part, words, row, value, end }: BarProps) {
  const share = (length: Num) => `${100 * Math.min((length ?? 0) / (end || 1), 1)}%`;
  return (
    <div className={styles.line}>
      <div className={styles.track}>
        <div className={styles.bar} data-part={part} style={{ width: share(value) }} />
        {isNumber(row.floor) && <div className={styles.floor} style={{ left: share(row.floor) }} />}
      </div>
      <span className={styles.number}>
        <span className={styles.hidden}>{words} </span>
        {significant(value)}&nbsp;{row.unit}
        {part === "steady" && <span className={styles.noise}> (steady)</span>}
        {part === "after" && <span className={styles.noise}> (noise {significant(row.floor)})</span>}
      </span>
    </div>
  );
}
