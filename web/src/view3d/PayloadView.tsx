import { Text } from "@mantine/core";

import { ProblemBox } from "../parts/ProblemBox";
import { Legend } from "./Legend";
import { usePayloadScene } from "./scenes";
import { Stage } from "./Stage";
import { usePlayer } from "./usePlayer";

/** A payload on its robot at home: the sensor's axes, where they may point, planned postures, and what was identified. */
export default function PayloadView({ payloadId, name, about: of }: { payloadId: string; name: string; about: string }) {
  const scene = usePayloadScene(payloadId, of);
  const player = usePlayer(scene.data, () => undefined);
  const { about, ask } = player;
  if (scene.isError) return <ProblemBox error={scene.error} retry={() => void scene.refetch()} />;
  return (
    <>
      <Stage player={player} title={`${name} in 3D`} waiting="Drawing the payload on its robot …" />
      {about && !player.failure && (
        <>
          <Legend about={about} ask={ask} />
          {about.notes.map((note) => (
            <Text key={note} size="xs" c="dimmed">
              {note}
            </Text>
          ))}
        </>
      )}
    </>
  );
}
