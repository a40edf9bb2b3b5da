import { Text } from "@mantine/core";
import { useMemo } from "react";

import type { Device } from "../../api/devices";
import { DeviceView } from "../../view3d/DeviceView";
import type { DeviceContent } from "./deviceFile";
import { tidy, withPoint } from "./edits";

type Props = {
  stored: Device;
  saved: DeviceContent;
  device: DeviceContent;
  band: string;
  point: number;
  choose: (band: string, point: number) => void;
  set: (next: DeviceContent, mark: string) => void;
};

/** The device in 3D; a point that is dragged there moves in the table too. */
export function DeviceIn3D({ stored, saved, device, band, point, choose, set }: Props) {
  const same = device.bands.filter((each) => sameRoute(each.name, saved, device));
  const moved = useMemo(
    () =>
      same.flatMap(({ name, via_points }) => via_points.map(({ xyz }, k) => ({ band: name, point: k, position: xyz }))),
    [device],
  );
  return (
    <>
      <DeviceView
        deviceId={stored.id}
        name={stored.name}
        moved={moved}
        chosen={{ band, point }}
        onChoose={(chosen) => chosen && choose(chosen.band, chosen.point)}
        onMove={({ band: name, point: k, position }) => {
          const at = device.bands.find((each) => each.name === name)?.via_points[k];
          if (!at || !sameRoute(name, saved, device)) return;
          set(withPoint(device, name, k, { ...at, xyz: tidy(position) }), `drag ${name} ${k}`);
        }}
      />
      <Text size="sm" c="dimmed">
        {same.length < device.bands.length
          ? "Bands with new, removed or re-linked points are shown here as they were saved; the drawing has them as they are."
          : "Click a via point, then drag its arrows; the table below follows."}
      </Text>
    </>
  );
}

/** Whether the band has the points that it was saved with, on the same links. */
function sameRoute(name: string, saved: DeviceContent, device: DeviceContent): boolean {
  const [before, now] = [saved, device].map((each) => each.bands.find((one) => one.name === name)?.via_points);
  return before?.length === now?.length && (before ?? []).every(({ link }, k) => link === now?.[k]?.link);
}
