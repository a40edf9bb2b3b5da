import { Text } from "@mantine/core";
import type { UseQueryResult } from "@tanstack/react-query";
import { useEffect, useRef } from "react";

import type { Cursor } from "../plots/cursor";
import { ProblemBox } from "../parts/ProblemBox";
import { Legend } from "./Legend";
import { Stage } from "./Stage";
import { Transport } from "./Transport";
import { usePlayer } from "./usePlayer";

/** name: of what is drawn. waiting: said while it is. */
type Props = { scene: UseQueryResult<ArrayBuffer | undefined>; name: string; waiting: string; cursor: Cursor };

/** A scene at the moment that the cursor shows; and the cursor moves while it plays. */
export function FollowedView({ scene: recording, name, waiting, cursor }: Props) {
  const wish = useRef(0); // number of the last time asked for
  const told = useRef<number | null>(null); // what the player said last is no wish to go there
  const player = usePlayer(recording.data, (said) => {
    if (said.type !== "time" || !said.playing || said.wish !== wish.current) return;
    told.current = said.time;
    cursor.move(said.time);
  });
  const { about, ask } = player;

  useEffect(() => {
    if (!about) return;
    const follow = () => {
      if (cursor.time === null || cursor.time === told.current) return;
      ask({ type: "seek", time: cursor.time, wish: ++wish.current });
    };
    follow();
    return cursor.subscribe(follow);
  }, [about, ask, cursor]);

  if (recording.isError) return <ProblemBox error={recording.error} retry={() => void recording.refetch()} />;
  return (
    <section aria-label={`3D view of ${name}`}>
      <Stage player={player} title={`${name} in 3D`} waiting={recording.isPending ? waiting : "Loading the 3D view …"} />
      {about && !player.failure && (
        <>
          <Transport player={player} about={about} cursor={cursor} />
          <Legend about={about} ask={ask} />
          {about.notes.map((note) => (
            <Text key={note} size="xs" c="dimmed">
              {note}
            </Text>
          ))}
        </>
      )}
    </section>
  );
}
