import { useEffect, useRef } from "react";

import { ProblemBox } from "../parts/ProblemBox";
import { useDeviceScene } from "./scenes";
import { Stage } from "./Stage";
import { usePlayer } from "./usePlayer";

/** A via point by its band and its place in that band, from 0. position: [m] in its link's frame. */
export type Moved = { band: string; point: number; position: [number, number, number] };

type Props = {
  deviceId: string;
  name: string;
  /** Points whose places differ from the stored device's. */
  moved?: Moved[];
  chosen?: { band: string; point: number } | null;
  onChoose?: (chosen: { band: string; point: number } | null) => void;
  /** Again and again while a point is dragged; `done` at the end. */
  onMove?: (moved: Moved, done: boolean) => void;
};

/** A device on its robot at rest. A click on a via point chooses it; then it can be dragged along its link's axes. */
export function DeviceView({ deviceId, name, moved, chosen, onChoose, onMove }: Props) {
  const scene = useDeviceScene(deviceId);
  const held = useRef<number | null>(null); // the point under the pointer is where it is dragged to
  const player = usePlayer(scene.data, (said) => {
    if (said.type === "moved") {
      held.current = said.done ? null : said.point;
      const at = placeOf(said.point);
      if (at) onMove?.({ ...at, position: said.position as Moved["position"] }, said.done);
    } else if (said.type === "chosen") onChoose?.(said.point < 0 ? null : placeOf(said.point));
  });
  const { about, ask } = player;
  const points = about?.points ?? [];

  const placeOf = (index: number) => {
    const band = points[index]?.band;
    return band === undefined ? null : { band, point: index - points.findIndex((each) => each.band === band) };
  };
  const indexOf = (band: string, point: number) => {
    const first = points.findIndex((each) => each.band === band);
    return first >= 0 && points[first + point]?.band === band ? first + point : -1;
  };

  useEffect(() => {
    for (const each of about ? (moved ?? []) : []) {
      const point = indexOf(each.band, each.point);
      if (point >= 0 && point !== held.current) ask({ type: "place", point, position: each.position });
    }
  }, [about, ask, moved]);
  useEffect(() => {
    if (about && chosen !== undefined) ask({ type: "choose", point: chosen ? indexOf(chosen.band, chosen.point) : -1 });
  }, [about, ask, chosen?.band, chosen?.point]);

  if (scene.isError) return <ProblemBox error={scene.error} retry={() => void scene.refetch()} />;
  return <Stage player={player} title={`${name} in 3D`} waiting="Drawing the device on its robot …" />;
}
