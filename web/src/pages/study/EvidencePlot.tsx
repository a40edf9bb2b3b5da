import { Table, Text } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";

import { isNumber, significant } from "../../parts/digits";
import { numbers, WideTable } from "../../parts/WideTable";
import styles from "./EvidencePlot.module.css";
import type { Curve, Finding, Num } from "./results";
import { spread } from "./stretch";
import { tickWords, ticks } from "../../plots/ticks";
import { capital } from "./words";

const HEIGHT = 280;
const MARGIN = { left: 58, right: 14, top: 10, bottom: 46 };
const DOUBT = 2;
const WORDS: Record<string, string> = { position: "angle", drive: "torque of the motor", load: "load on the joint" };

type Props = { finding: Finding; effect: string };

/** What the model lacks, of a joint's torque or a sensor's reading, over what the effect depends on: means of bins with two standard errors. */
export function EvidencePlot({ finding: { curve, held_out: held }, effect }: Props) {
  const { ref, width } = useElementSize<HTMLDivElement>();
  const { name, unit } = curve.coordinate;
  const over = `${WORDS[name] ?? name.replaceAll("_", " ")}${unit && unit !== "1" ? ` [${unit}]` : ""}`;
  const torque = !held.channel.startsWith("ft.") && !held.channel.startsWith("base.");
  const channel = held.channel_words ?? held.channel;
  const way = curve.along_motion ? " along its motion" : "";
  const lack = torque ? `Torque that acts on ${channel}${way} and that the model lacks` : `What the model lacks of ${channel}`;
  const own = torque ? "torque of the effect" : "the effect’s own part";
  return (
    <figure className={styles.figure}>
      <p className={styles.key} aria-hidden>
        <Key look="before">without it, ± 2 standard errors</Key>
        <Key look="after">with it, ± 2 standard errors</Key>
        <Key look="model">{own}</Key>
      </p>
      <div ref={ref} className={styles.room}>
        {width > 0 && <Picture curve={curve} width={width} over={over} words={`${lack}, over ${over}; the table below holds the numbers`} />}
      </div>
      <figcaption>
        <Text size="xs" c="dimmed">
          {lack}, over {over}: means of bins, without and with {effect}.
        </Text>
      </figcaption>
      <details className={styles.numbers}>
        <summary>The same as a table</summary>
        <Numbers curve={curve} over={over} own={capital(own)} title={capital(effect)} />
      </details>
    </figure>
  );
}

function Key({ look, children }: { look: string; children: string }) {
  return (
    <span className={styles.entry}>
      <svg width={26} height={10}>
        <line x1={0} x2={26} y1={5} y2={5} className={styles[look]} />
        {look !== "model" && <circle cx={13} cy={5} r={look === "before" ? 3.5 : 2.5} className={styles[`${look}Dot`]} />}
      </svg>
      {children}
    </span>
  );
}

function Picture({ curve, width, over, words }: { curve: Curve; width: number; over: string; words: string }) {
  const at = curve.coordinate.values;
  const across = spread(at.filter(isNumber));
  const values = [...curve.model, ...curve.after, ...curve.before].filter(isNumber);
  const doubt = DOUBT * Math.max(0, ...curve.spread.filter(isNumber));
  const [low, high] = [Math.min(0, ...values) - doubt, Math.max(0, ...values) + doubt];
  const inner = width - MARGIN.left - MARGIN.right;
  const tall = HEIGHT - MARGIN.top - MARGIN.bottom;
  const x = (value: number) => MARGIN.left + across.place(value) * inner;
  const y = (value: number) => MARGIN.top + ((high - value) / (high - low)) * tall;
  const up = ticks(low, high, 5);
  return (
    <svg width={width} height={HEIGHT} role="img" aria-label={words} className={styles.picture}>
      {up.map((tick, k) => (
        <g key={tick}>
          <line x1={MARGIN.left} x2={width - MARGIN.right} y1={y(tick)} y2={y(tick)} className={tick === 0 ? styles.zero : styles.grid} />
          <text x={MARGIN.left - 8} y={y(tick) + 4} textAnchor="end">
            {tickWords(up)[k]}
          </text>
        </g>
      ))}
      {across.ticks.map(({ value, text }) => (
        <g key={value}>
          <line x1={x(value)} x2={x(value)} y1={MARGIN.top} y2={MARGIN.top + tall} className={styles.grid} />
          <text x={x(value)} y={HEIGHT - MARGIN.bottom + 17} textAnchor="middle">
            {text}
          </text>
        </g>
      ))}
      <text x={MARGIN.left + 0.5 * inner} y={HEIGHT - 8} textAnchor="middle">
        {over}
        {across.stretched && ", stretched about zero"}
      </text>
      <text transform={`translate(13 ${MARGIN.top + 0.5 * tall}) rotate(-90)`} textAnchor="middle">
        [{curve.unit}]
      </text>
      <path d={path(at, curve.model, x, y)} className={styles.model} />
      <Points at={at} values={curve.before} doubts={curve.spread} x={x} y={y} look="before" />
      <Points at={at} values={curve.after} doubts={curve.spread} x={x} y={y} look="after" />
    </svg>
  );
}

type Scale = (value: number) => number;
type PointsProps = { at: Num[]; values: Num[]; doubts: Num[]; x: Scale; y: Scale; look: "before" | "after" };

function Points({ at, values, doubts, x, y, look }: PointsProps) {
  return (
    <>
      <path d={path(at, values, x, y)} className={styles[look]} />
      {at.map((place, k) => {
        const [value, doubt] = [values[k], doubts[k]];
        if (!isNumber(place) || !isNumber(value)) return null;
        return (
          <g key={k}>
            {isNumber(doubt) && (
              <line x1={x(place)} x2={x(place)} y1={y(value - DOUBT * doubt)} y2={y(value + DOUBT * doubt)} className={styles[`${look}Bar`]} />
            )}
            <circle cx={x(place)} cy={y(value)} r={look === "before" ? 3.5 : 2.5} className={styles[`${look}Dot`]} />
          </g>
        );
      })}
    </>
  );
}

function path(at: Num[], values: Num[], x: Scale, y: Scale): string {
  let text = "";
  let pen = "M";
  at.forEach((place, k) => {
    const value = values[k];
    if (!isNumber(place) || !isNumber(value)) pen = "M";
    else {
      text += `${pen}${x(place).toFixed(1)} ${y(value).toFixed(1)}`;
      pen = "L";
    }
  });
  return text;
}

function Numbers({ curve, over, own, title }: { curve: Curve; over: string; own: string; title: string }) {
  return (
    <WideTable label={`Evidence for ${title}`} columns={numbers(over, "Without it", "With it", "Standard error", own)}>
      {curve.coordinate.values.map((place, k) => (
        <Table.Tr key={k}>
          <Table.Th scope="row" data-number>
            {significant(place)}
          </Table.Th>
          {[curve.before, curve.after, curve.spread, curve.model].map((values, n) => (
            <Table.Td key={n} data-number>
              {significant(values[k])}
            </Table.Td>
          ))}
        </Table.Tr>
      ))}
    </WideTable>
  );
}
