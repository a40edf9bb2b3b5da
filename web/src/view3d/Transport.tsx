import { ActionIcon, Group, NativeSelect, Slider, Text, Tooltip } from "@mantine/core";
import { IconHome, IconPlayerPauseFilled, IconPlayerPlayFilled } from "@tabler/icons-react";
import { useState } from "react";

import { useTime, type Cursor } from "../plots/cursor";
import type { About } from "./player";
import styles from "./Transport.module.css";
import type { Player } from "./usePlayer";

const SPEEDS = ["0.1", "0.25", "0.5", "1", "2", "4"];

/** Play, pause, go to a moment, how fast, and back to the first view. */
export function Transport({ player, about, cursor }: { player: Player; about: About; cursor: Cursor }) {
  const time = useTime(cursor) ?? about.start;
  const [speed, setSpeed] = useState("1");
  const play = (at: string) => player.ask({ type: "play", speed: Number(at) });
  const PlayIcon = player.playing ? IconPlayerPauseFilled : IconPlayerPlayFilled;
  return (
    <Group gap="sm" mt="xs" mb="xs" wrap="nowrap">
      <ActionIcon
        variant="default"
        size="lg"
        aria-label={player.playing ? "Pause" : "Play"}
        onClick={() => (player.playing ? player.ask({ type: "pause" }) : play(speed))}
      >
        <PlayIcon size={18} aria-hidden />
      </ActionIcon>
      <Slider
        className={styles.time}
        aria-label="Time"
        thumbLabel="Time"
        min={about.start}
        max={about.end}
        step={1 / about.fps}
        value={Math.min(Math.max(time, about.start), about.end)}
        label={null}
        onChange={(at) => cursor.move(at)}
      />
      <Text size="sm" className={styles.reading}>
        {time.toFixed(2)} / {about.end.toFixed(2)} s
      </Text>
      <NativeSelect
        size="xs"
        className={styles.speed}
        aria-label="Speed"
        value={speed}
        data={SPEEDS.map((each) => ({ value: each, label: `${each} ×` }))}
        onChange={(event) => {
          setSpeed(event.currentTarget.value);
          if (player.playing) play(event.currentTarget.value);
        }}
      />
      <Tooltip label="Back to the first view">
        <ActionIcon variant="default" size="lg" aria-label="Back to the first view" onClick={() => player.ask({ type: "camera" })}>
          <IconHome size={18} aria-hidden />
        </ActionIcon>
      </Tooltip>
    </Group>
  );
}
