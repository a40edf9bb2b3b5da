import { Text } from "@mantine/core";

import type { Quantity, WornIn } from "../../api/betweenLabs";
import { figure } from "../../parts/digits";
import styles from "./Forest.module.css";

const Z95 = 1.96;
const WIDTH = 640;
const LEFT = 180;
const ROW = 26;

/** Each lab's value with its 95 % interval, and the weighted mean of all. The table below holds the numbers. */
export function Forest({ title, quantity, studies }: { title: string; quantity: Quantity; studies: WornIn[] }) {
  const { mean, std } = quantity.found;
  const rows = quantity.rows.map((row, k) => {
    const study = studies[row]!;
    const band = study.bands.find((each) => each.identifiable && each.stiffness_n_per_m.value === quantity.values[k]);
    return { name: study.lab, value: quantity.values[k]!, std: band?.stiffness_n_per_m.std ?? 0 };
  });
  if (mean !== null && std !== null) rows.push({ name: "Weighted mean", value: mean, std });
  const ends = rows.flatMap((row) => [row.value - Z95 * row.std, row.value + Z95 * row.std]);
  const [low, high] = [Math.min(...ends), Math.max(...ends)];
  const span = high - low || 1;
  const at = (value: number) => LEFT + 10 + ((value - low) / span) * (WIDTH - LEFT - 20);
  const height = rows.length * ROW + 24;
  return (
    <figure className={styles.figure}>
      <Text component="figcaption" size="sm" fw={600}>
        {title}
      </Text>
      <svg viewBox={`0 0 ${WIDTH} ${height}`} className={styles.plot} role="img" aria-label={`${title}: ${rows.map((row) => `${row.name} ${figure(row.value)}`).join(", ")}`}>
        {mean !== null && <line x1={at(mean)} x2={at(mean)} y1={4} y2={height - 22} className={styles.mean} />}
        {rows.map((row, k) => {
          const y = k * ROW + ROW / 2;
          return (
            <g key={k}>
              <text x={LEFT} y={y + 4} textAnchor="end" className={styles.name}>
                {row.name.length > 24 ? `${row.name.slice(0, 23)}…` : row.name}
              </text>
              <line x1={at(row.value - Z95 * row.std)} x2={at(row.value + Z95 * row.std)} y1={y} y2={y} className={styles.interval} />
              <circle cx={at(row.value)} cy={y} r={4} className={styles.value} />
            </g>
          );
        })}
        <text x={at(low)} y={height - 4} className={styles.name}>{figure(low, 3)}</text>
        <text x={at(high)} y={height - 4} textAnchor="end" className={styles.name}>{figure(high, 3)}</text>
      </svg>
    </figure>
  );
}
