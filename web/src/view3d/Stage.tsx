import { Alert, Loader, Text } from "@mantine/core";
import { IconCube3dSphere } from "@tabler/icons-react";

import { address } from "../app/base";
import styles from "./Stage.module.css";
import type { Player } from "./usePlayer";

const LATE = "The 3D view is slow to start, as over a slow line or on a busy machine. The plots and tables show the same numbers.";

type Props = { player: Player; title: string; waiting: string };

/** The frame with viser's client, or why there is none. The frame may run its own scripts and nothing else. */
export function Stage({ player, title, waiting }: Props) {
  const late = player.failure === "timeout"; // it may still come, if its frame stays
  if (player.failure && !late) return <NoView reason={player.failure} />;
  return (
    <div className={styles.stage}>
      <iframe ref={player.frame} className={styles.frame} title={title} sandbox="allow-scripts" src={address("api/v1/scenes/player")} />
      {!player.about && (
        <div className={styles.waiting} role="status">
          <Loader size="sm" />
          <Text size="sm">{late ? LATE : waiting}</Text>
        </div>
      )}
    </div>
  );
}

function NoView({ reason }: { reason: string }) {
  const why =
    reason === "webgl"
      ? "This browser cannot draw in 3D: WebGL 2 is missing or switched off. The plots and tables show the same numbers."
      : `The 3D view stopped: ${reason}. Load the page again; the plots and tables show the same numbers.`;
  return (
    <Alert role="alert" color="gray" icon={<IconCube3dSphere aria-hidden />} title="No 3D view">
      {why}
    </Alert>
  );
}
