import { Checkbox, useComputedColorScheme } from "@mantine/core";

import { NONE, significant, withStd } from "../parts/digits";
import type { Line, Panel } from "./channels";
import { useIsSet, type Cursor } from "./cursor";
import { pen } from "./looks";
import styles from "./Readings.module.css";
import type { Sample } from "./series";

type Props = {
  panel: Panel;
  hidden: readonly string[];
  sample: Sample | null;
  cursor: Cursor;
  onToggle: (channel: string) => void;
};

/** What each line is at the cursor: the sample next to it, from the file itself, not what is drawn. */
export function Readings({ panel, hidden, sample, cursor, onToggle }: Props) {
  const known = useIsSet(cursor) ? sample : null;
  return (
    <table className={styles.table}>
      <caption className={styles.caption}>{known ? `At ${known.t.toFixed(3)} s` : "Point at a plot to read its values"}</caption>
      <thead className={styles.head}>
        <tr>
          <th scope="col">Shown</th>
          <th scope="col">Value [{panel.unit}]</th>
        </tr>
      </thead>
      <tbody>
        {panel.lines.map((line) => (
          <tr key={line.channel}>
            <th scope="row">
              <Checkbox
                size="xs"
                styles={{ label: { fontSize: "var(--mantine-font-size-sm)" } }}
                checked={!hidden.includes(line.channel)}
                onChange={() => onToggle(line.channel)}
                label={
                  <span className={styles.name}>
                    <Stroke line={line} />
                    {line.words}
                  </span>
                }
              />
            </th>
            <td className={styles.value}>{known ? reading(line, known) : NONE}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** The line's own stroke, as in the plot. */
function Stroke({ line }: { line: Line }) {
  const { colour, width, dash } = pen(line.look, useComputedColorScheme("light"));
  return (
    <svg width={26} height={8} aria-hidden className={styles.stroke}>
      <line x1={0} x2={26} y1={4} y2={4} stroke={colour} strokeWidth={width} strokeDasharray={dash?.join(" ")} />
    </svg>
  );
}

/** The value, ± its standard deviation where the file has one, or the interval that friction leaves. */
function reading({ channel, std, low, high }: Line, { values }: Sample): string {
  const value = values[channel] ?? null;
  const [bottom, top] = [low ? values[low] : null, high ? values[high] : null];
  if (typeof bottom === "number" && typeof top === "number") return `at rest ${significant(bottom)} … ${significant(top)}`;
  const doubt = std ? values[std] : null;
  const [shown, spread] = withStd(value, typeof doubt === "number" ? doubt : null);
  return spread === NONE ? shown : `${shown} ± ${spread}`;
}

/** The same in one sentence, for who listens. */
export function readingWords(lines: readonly Line[], sample: Sample | null, unit: string): string {
  if (!sample) return "no cursor";
  const values = lines.map((line) => `${line.words} ${reading(line, sample)} ${unit}`.replace(`${NONE} ${unit}`, "no value"));
  return `${sample.t.toFixed(3)} s: ${values.join(", ")}`;
}
