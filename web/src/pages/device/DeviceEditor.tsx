import { ActionIcon, Button, Group, SimpleGrid, Stack, Text, Title, Tooltip } from "@mantine/core";
import { useHotkeys } from "@mantine/hooks";
import { IconArrowBackUp, IconArrowForwardUp } from "@tabler/icons-react";
import { lazy, useMemo, useState } from "react";

import type { Device } from "../../api/devices";
import type { Robot, RobotModel } from "../../api/robots";
import { useKeep } from "../../app/kept";
import { ForMembers } from "../../parts/ForMembers";
import { linkNamed, placeOn } from "../../parts/place";
import { count } from "../../parts/size";
import { BAND_COLOURS, StickFigure, type DrawnBand } from "../../parts/StickFigure";
import { DrawnOr3D } from "../../parts/DrawnOr3D";
import { Empty } from "../../parts/Empty";
import { BandTable } from "./BandTable";
import { BandValues } from "./BandValues";
import { readDevice, type DeviceContent } from "./deviceFile";
import { differences, hindrance } from "./differences";
import { PullTable } from "./PullTable";
import { SaveDevice } from "./SaveDevice";
import { SpecimenForm } from "./SpecimenForm";
import { useHistory } from "./useHistory";
import { ViaPointTable } from "./ViaPointTable";
import { WhatIf } from "./WhatIf";

const DeviceIn3D = lazy(() => import("./DeviceIn3D").then((module) => ({ default: module.DeviceIn3D })));

type Props = { device: Device; robot: Robot; text: string };

/** The bands of a device, changed in a table and by sliders, and what the change would do over a recorded motion. */
export function DeviceEditor({ device, robot, text }: Props) {
  const saved = useMemo(() => readDevice(text), [text]);
  const history = useHistory(saved);
  useKeep("device", history.now === saved ? null : history.now, (changed) => changed && history.set(changed, "kept"));
  const [band, setBand] = useState(saved.bands[0]?.name ?? "");
  const [point, setPoint] = useState(0);
  const [saving, setSaving] = useState(false);
  useHotkeys(
    [
      ["mod+Z", history.undo],
      ["mod+shift+Z", history.redo],
      ["mod+Y", history.redo],
    ],
    [],
  );
  const model = robot.summary.model;
  const now = history.now;
  const changed = differences(saved, now);
  const hindered = hindrance(now);
  if (!model) {
    return (
      <Empty title="Its robot’s links are not at hand">
        <Text>The robot was stored by an earlier version of the service. Hand it in again to edit devices on it.</Text>
      </Empty>
    );
  }
  const mark = (name: string, k: number) => {
    setBand(name);
    setPoint(k);
  };
  return (
    <>
      <SimpleGrid cols={{ base: 1, lg: 2 }} spacing="xl">
        <Stack gap="md">
          <Title order={2} size="h3">
            Bands
          </Title>
          <BandTable device={now} model={model} chosen={band} choose={(name) => mark(name, 0)} />
          <PullTable device={device} band={band} />
        </Stack>
        <DrawnOr3D
          drawing={
            <StickFigure
              model={model}
              label={`${device.name} on ${robot.name}, all joints at zero`}
              bands={[...(changed.length > 0 ? drawn(saved, model, true) : []), ...onTop(drawn(now, model, false), band)]}
              marked={{ band, point }}
              pick={mark}
            />
          }
          solid={() => (
            <DeviceIn3D stored={device} saved={saved} device={now} band={band} point={point} choose={mark} set={history.set} />
          )}
        />
      </SimpleGrid>
      <section aria-labelledby="edit">
        <Group justify="space-between" mb="sm">
          <Title order={2} size="h3" id="edit">
            Change it
          </Title>
          <Group gap="xs">
            <Text size="sm" c="dimmed" role="status">
              {changed.length > 0 ? `${count(changed.length, "change")}, not saved` : "As saved"}
            </Text>
            <Tooltip label="Undo (Ctrl+Z)">
              <ActionIcon variant="default" size="lg" aria-label="Undo" disabled={!history.canUndo} onClick={history.undo}>
                <IconArrowBackUp size={18} aria-hidden />
              </ActionIcon>
            </Tooltip>
            <Tooltip label="Redo (Ctrl+Shift+Z)">
              <ActionIcon variant="default" size="lg" aria-label="Redo" disabled={!history.canRedo} onClick={history.redo}>
                <IconArrowForwardUp size={18} aria-hidden />
              </ActionIcon>
            </Tooltip>
            <Button variant="default" disabled={changed.length === 0} onClick={history.reset}>
              Back to saved
            </Button>
            <ForMembers told>
            <Button disabled={changed.length === 0 || hindered !== null} onClick={() => setSaving(true)}>
              Save as a new version
            </Button>
            </ForMembers>
          </Group>
        </Group>
        {hindered && (
          <Text c="var(--mantine-color-error)" role="alert" mb="sm">
            {hindered}
          </Text>
        )}
        <SimpleGrid cols={{ base: 1, lg: 2 }} spacing="xl">
          <Stack gap="md">
            <BandValues saved={saved} device={now} band={band} choose={(name) => mark(name, 0)} set={history.set} />
            <ViaPointTable
              model={model}
              saved={saved}
              device={now}
              band={band}
              point={point}
              choose={setPoint}
              set={history.set}
            />
            <SpecimenForm device={now} set={history.set} />
          </Stack>
          <WhatIf robot={robot} device={now} hindered={hindered !== null} />
        </SimpleGrid>
      </section>
      <SaveDevice opened={saving} close={() => setSaving(false)} device={device} text={text} content={now} changes={changed} />
    </>
  );
}

/** In the side view the left and the right lie behind each other: the chosen band in front. */
function onTop(bands: DrawnBand[], chosen: string): DrawnBand[] {
  return [...bands.filter((each) => each.name !== chosen), ...bands.filter((each) => each.name === chosen)];
}

function drawn(device: DeviceContent, model: RobotModel, old: boolean): DrawnBand[] {
  return device.bands.map((band, k) => ({
    name: band.name,
    colour: BAND_COLOURS[k % BAND_COLOURS.length] ?? "",
    old,
    points: band.via_points.flatMap(({ link, xyz }) => {
      const on = linkNamed(model, link);
      return on ? [{ place: placeOn(on, xyz), link }] : [];
    }),
  }));
}
