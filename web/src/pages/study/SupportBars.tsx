import { useComputedColorScheme } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";

import { isNumber } from "../../parts/digits";
import { pen } from "../../plots/looks";
import { ticks, tickWords } from "../../plots/ticks";
import { APPROACHES } from "./approaches";
import type { Support } from "./results";
import styles from "./SupportBars.module.css";

const ROW = 18;
const LABEL = 24;
const NAMES = 130; // pixels for the approaches' names
const WIDEST = 860;
const DOUBT = 2;

/** Peak torque by each approach, with two standard deviations, on one scale. The table below holds the numbers. */
export function SupportBars({ motion, rows }: { motion: string; rows: Support[] }) {
  const { ref, width } = useElementSize<HTMLDivElement>();
  const words = `Peak torque of the device in motion ${motion}, by each approach; the table below holds the numbers`;
  return (
    <figure className={styles.figure}>
      <div ref={ref}>{width > 0 && <Picture rows={rows} width={Math.min(width, WIDEST)} words={words} />}</div>
    </figure>
  );
}

function Picture({ rows, width, words }: { rows: Support[]; width: number; words: string }) {
  const marks = rows.map(marksOf);
  const all = marks.flat();
  if (!all.length) return null;
  const low = Math.min(0, ...all.map(({ value, doubt }) => value - doubt));
  const high = Math.max(0, ...all.map(({ value, doubt }) => value + doubt));
  const x = (value: number) => NAMES + 8 + ((value - low) / (high - low || 1)) * (width - NAMES - 20);
  const found = ticks(low, high, Math.max((width - NAMES) / 90, 2));
  const tall = marks.reduce((sum, each) => sum + LABEL + ROW * each.length + 8, 0);
  let top = 0;
  return (
    <svg width={width} height={tall + 40} className={styles.picture} role="img" aria-label={words}>
      {found.map((tick, k) => (
        <g key={tick}>
          <line x1={x(tick)} x2={x(tick)} y1={0} y2={tall} className={Math.abs(tick) < 1e-9 ? styles.zero : styles.grid} />
          <text x={x(tick)} y={tall + 16} textAnchor="middle">
            {tickWords(found)[k]}
          </text>
        </g>
      ))}
      <text x={0.5 * (NAMES + width)} y={tall + 34} textAnchor="middle">
        peak torque [N·m], ± 2 std
      </text>
      {rows.map((each, k) => {
        const start = top;
        top += LABEL + ROW * (marks[k]?.length ?? 0) + 8;
        return <Joint key={`${each.device} ${each.joint}`} name={each.joint} device={each.device} marks={marks[k] ?? []} top={start} x={x} />;
      })}
    </svg>
  );
}

type Mark = { words: string; look: (typeof APPROACHES)[number]["look"]; value: number; doubt: number };

function marksOf(each: Support): Mark[] {
  return APPROACHES.flatMap(({ key, words, look }) => {
    const peak = each.peak || key === "band_model" ? each.approaches[key]?.peak : undefined; // undecided: a mark without doubt would look sure
    return peak && isNumber(peak.value) ? [{ words, look, value: peak.value, doubt: DOUBT * (peak.std ?? 0) }] : [];
  });
}

type JointProps = { name: string; device: string; marks: Mark[]; top: number; x: (value: number) => number };

function Joint({ name, device, marks, top, x }: JointProps) {
  const scheme = useComputedColorScheme("light");
  return (
    <g>
      <text x={0} y={top + 16} className={styles.name}>
        {name}
        <tspan className={styles.device}> {device}</tspan>
      </text>
      {marks.map(({ words, look, value, doubt }, k) => {
        const middle = top + LABEL + ROW * (k + 0.5);
        const { colour } = pen(look, scheme);
        return (
          <g key={words} stroke={colour} fill={colour}>
            <text x={0} y={middle + 4}>
              {words}
            </text>
            <line x1={x(0)} x2={x(value)} y1={middle} y2={middle} strokeWidth={8} opacity={0.4} />
            <line x1={x(value - doubt)} x2={x(value + doubt)} y1={middle} y2={middle} strokeWidth={2} />
            <circle cx={x(value)} cy={middle} r={4} />
          </g>
        );
      })}
    </g>
  );
}
