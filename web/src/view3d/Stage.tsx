import { Alert, Loader, Text } from "@mantine/core";
import { IconCube3dSphere } from "@tabler/icons-react";

import { address } from "../app/base";
import styles from "./Stage.module.css";
import type { Player } from "./usePlayer";

type Props = { player: Player; title: string; waiting: string };

/** The frame with viser's client, or why there is none. The frame may run its own scripts and nothing else. */
export function Stage({ player, title, waiting }: Props) {
  if (player.failure) return <NoView reason={player.failure} />;
  return (
    <div className={styles.stage}>
      <iframe ref={player.frame} className={styles.frame} title={title} sandbox="allow-scripts" src={address("api/v1/scenes/player")} />
      {!player.about && (
        <div className={styles.waiting} role="status">
          <Loader size="sm" />
          <Text size="sm">{waiting}</Text>
        </div>
      )}
    </div>
  );
}

function NoView({ reason }: { reason: string }) {
  const why =
    reason === "webgl"
      ? "This browser cannot draw in 3D: WebGL 2 is missing or switched off. The plots and tables show the same numbers."
      : reason === "timeout"
        ? "The 3D view did not start within half a minute. Load the page again; the plots and tables show the same numbers."
        : `The 3D view stopped: ${reason}. Load the page again; the plots and tables show the same numbers.`;
  return (
    <Alert role="alert" color="gray" icon={<IconCube3dSphere aria-hidden />} title="No 3D view">
      {why}
    </Alert>
  );
}
