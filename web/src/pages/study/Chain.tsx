import { Text, Title } from "@mantine/core";

import { isNumber, significant } from "../../parts/digits";
import styles from "./Chain.module.css";
import type { Link } from "./results";
import { capital } from "./words";

const FLOORS = "floors";
const CUT = 4; // a first bar longer than this times the next is cut, or nothing could be told of the others

/** One bar per model: grey what noise explains, coloured what is above it. */
export function Chain({ id, title, chain }: { id: string; title: string; chain: Link[] }) {
  const floor = chain.at(-1)?.noise_floor ?? null;
  const lengths = [...chain.map((each) => each.rmse), floor].filter(isNumber);
  const others = Math.max(...lengths.slice(1), 1e-12);
  const end = Math.min(Math.max(...lengths), CUT * others);
  return (
    <section aria-labelledby={id}>
      <Title order={2} size="h3" id={id} mb={4}>
        {title}
      </Title>
      <Text size="sm" c="dimmed" mb="xs">
        RMSE of the channels in question{chain[0]?.unit === FLOORS && ", each in multiples of its noise floor"}, in steady motion on
        held-out logs. {chain[0]?.what === "robot" && "Above the cut-off, of which the model says nothing, the noise alone counts. "}
        Grey: what noise explains; coloured: what is above it.{lengths.some((each) => each > end) && " The bar with a gap is longer than drawn."}
      </Text>
      <ol className={styles.chain}>
        {chain.map((each, k) => (
          <li key={k} className={styles.step}>
            <Words name={capital(each.step)} note={worst(each)} />
            <Bar length={each.rmse} floor={each.noise_floor} end={end} unit={each.unit} first={k === 0 && chain.length > 1} />
          </li>
        ))}
        <li className={styles.step}>
          <Words name="Noise floor" note="what the sensors’ own noise leaves of a perfect model" />
          <Bar length={floor} floor={floor} end={end} unit={chain[0]!.unit} />
        </li>
      </ol>
    </section>
  );
}

function Words({ name, note }: { name: string; note: string }) {
  return (
    <div className={styles.words}>
      <span className={styles.name}>{name}</span>
      <span className={styles.note}>{note}</span>
    </div>
  );
}

type BarProps = { length: number | null; floor: number | null; end: number; unit: string; first?: boolean };

function Bar({ length, floor, end, unit, first }: BarProps) {
  const whole = Math.min(length ?? 0, end);
  const noise = Math.min(floor ?? 0, whole);
  const share = (value: number) => `${(100 * value) / end}%`;
  return (
    <div className={styles.line} data-wide={unit === FLOORS || undefined}>
      <div className={styles.track}>
        <div className={styles.noise} style={{ width: share(noise) }} />
        <div className={styles.excess} data-first={first || undefined} data-cut={(length ?? 0) > end || undefined} style={{ left: share(noise), width: share(whole - noise) }} />
        {isNumber(floor) && <div className={styles.floor} style={{ left: share(Math.min(floor, end)) }} />}
      </div>
      <span className={styles.number}>
        {significant(length)}&nbsp;{unit === FLOORS ? "× noise floor" : unit}
      </span>
    </div>
  );
}

function worst({ worst, worst_words, worst_rmse, worst_floor, unit }: Link): string {
  if (!worst) return "";
  const channel = worst_words ?? worst;
  if ((worst_rmse ?? 0) <= (worst_floor ?? 0)) return "every channel at its floor or below";
  if (unit === FLOORS && isNumber(worst_rmse) && isNumber(worst_floor) && worst_floor > 0)
    return `furthest above its floor: ${channel}, ${significant(worst_rmse / worst_floor)} times`;
  return `furthest above its floor: ${channel}, ${significant(worst_rmse)} over ${significant(worst_floor)}`;
}
