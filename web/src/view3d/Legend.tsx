import { Checkbox, Group } from "@mantine/core";
import { useEffect, useState } from "react";

import styles from "./Legend.module.css";
import type { About, Asked, LegendEntry } from "./player";

const OTHERS: Record<string, string> = { robot: "robot", marks: "joints that the model does not explain", floor: "floor" };

/** What the colours and sizes mean, with numbers; each can be hidden. */
export function Legend({ about, ask }: { about: About; ask: (asked: Asked) => void }) {
  const [hidden, setHidden] = useState(about.hidden);
  useEffect(() => setHidden(about.hidden), [about]);
  const toggle = (layer: string) => {
    const visible = hidden.includes(layer);
    setHidden(visible ? hidden.filter((each) => each !== layer) : [...hidden, layer]);
    ask({ type: "show", layer, visible });
  };
  return (
    <Group gap="lg" mb="xs" role="group" aria-label="What is shown">
      {[...about.layers].sort((a, b) => Number(a in OTHERS) - Number(b in OTHERS)).map((layer) => {
        const entries = about.legend.filter((entry) => entry.layer === layer);
        if (!entries.length && !OTHERS[layer]) return null;
        return (
          <Checkbox
            key={layer}
            size="xs"
            checked={!hidden.includes(layer)}
            onChange={() => toggle(layer)}
            label={entries.length ? entries.map((entry) => <Entry key={entry.label} entry={entry} />) : OTHERS[layer]}
          />
        );
      })}
    </Group>
  );
}

function Entry({ entry }: { entry: LegendEntry }) {
  const { scale, low, high, unit } = entry;
  return (
    <span className={styles.entry}>
      {scale ? (
        <>
          {entry.label} {low}
          <span aria-hidden className={styles.scale} style={{ background: `linear-gradient(to right, ${scale.join(", ")})` }} />
          {high} {unit}
        </>
      ) : (
        <>
          <span aria-hidden className={styles.swatch} style={{ background: entry.color }} />
          {entry.label}
          {entry.size && ` (${entry.size})`}
        </>
      )}
    </span>
  );
}
