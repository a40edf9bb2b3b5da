import { useComputedColorScheme } from "@mantine/core";

import { isNumber } from "../../parts/digits";
import { pen } from "../../plots/looks";
import { ticks, tickWords } from "../../plots/ticks";
import { APPROACHES } from "./approaches";
import type { Support } from "./results";
import styles from "./SupportBars.module.css";

const ROW = 18;
const LABEL = 22;
const WIDTH = 640;
const DOUBT = 2;

/** Peak torque by each approach, with two standard deviations, on one scale. The table below holds the numbers. */
export function SupportBars({ motion, rows }: { motion: string; rows: Support[] }) {
  const scheme = useComputedColorScheme("light");
  const marks = rows.map((each) =>
    APPROACHES.flatMap(({ key, words, look }) => {
      const peak = each.approaches[key]?.peak;
      return peak && isNumber(peak.value) ? [{ words, look, value: peak.value, doubt: DOUBT * (peak.std ?? 0) }] : [];
    }),
  );
  const all = marks.flat();
  if (!all.length) return null;
  const largest = Math.max(...all.map(({ value }) => Math.abs(value)));
  const end = Math.max(...all.map(({ value, doubt }) => Math.min(Math.abs(value) + doubt, 2 * largest)));
  const low = all.some(({ value, doubt }) => value - doubt < 0) ? -end : 0;
  const high = all.some(({ value, doubt }) => value + doubt > 0) ? end : 0;
  const x = (value: number) => 8 + ((Math.min(Math.max(value, low), high) - low) / (high - low)) * (WIDTH - 16);
  const found = ticks(low, high, 6);
  let y = 4;
  const drawn = rows.map((each, k) => {
    const top = y;
    y += LABEL + ROW * (marks[k]?.length ?? 0) + 8;
    return (
      <g key={`${each.device} ${each.joint}`}>
        <text x={8} y={top + 15} className={styles.name}>
          {each.joint}
          <tspan className={styles.device}> {each.device}</tspan>
        </text>
        {marks[k]?.map(({ words, look, value, doubt }, n) => {
          const middle = top + LABEL + ROW * (n + 0.5);
          const { colour } = pen(look, scheme);
          return (
            <g key={words} stroke={colour} fill={colour}>
              <line x1={x(0)} x2={x(value)} y1={middle} y2={middle} strokeWidth={7} opacity={0.45} />
              <line x1={x(value - doubt)} x2={x(value + doubt)} y1={middle} y2={middle} strokeWidth={2} />
              <circle cx={x(value)} cy={middle} r={4} />
              <text x={value < 0 ? x(0) + 6 : x(0) - 6} y={middle + 4} textAnchor={value < 0 ? "start" : "end"} className={styles.words} stroke="none">
                {words}
              </text>
            </g>
          );
        })}
      </g>
    );
  });
  const left = low < 0 ? 0 : -120;
  const right = high > 0 ? WIDTH : WIDTH + 120;
  return (
    <figure className={styles.figure}>
      <svg viewBox={`${left} 0 ${right - left} ${y + 34}`} className={styles.picture} role="img" aria-label={`Peak torque of the device in motion ${motion}, by each approach; the table below holds the numbers`}>
        {found.map((tick, k) => (
          <g key={tick}>
            <line x1={x(tick)} x2={x(tick)} y1={0} y2={y} className={tick === 0 ? styles.zero : styles.grid} />
            <text x={x(tick)} y={y + 16} textAnchor="middle" className={styles.tick}>
              {tickWords(found)[k]}
            </text>
          </g>
        ))}
        <text x={0.5 * (left + right)} y={y + 32} textAnchor="middle" className={styles.tick}>
          peak torque [N·m], ± 2 std
        </text>
        {drawn}
      </svg>
    </figure>
  );
}
