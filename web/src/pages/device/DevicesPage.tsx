import { Badge, Stack, Text } from "@mantine/core";

import { useDevices, type Device } from "../../api/devices";
import { Empty } from "../../parts/Empty";
import { PageTitle } from "../../parts/PageTitle";
import { count } from "../../parts/size";
import { Standing, ThingList, ThingRow, useNewestOfEach } from "../../parts/ThingList";
import { useSought } from "../../parts/useSought";
import { DevicesOfStudies } from "./DevicesOfStudies";
import { HandInDevice } from "./HandInDevice";

export function Component() {
  const sought = useSought();
  const devices = useDevices(sought.words ? { search: sought.words } : {});
  const newest = useNewestOfEach(devices);
  const nothing = `No device has “${sought.words}” in its name or its robot’s.`;
  return (
    <>
      <PageTitle title="Devices" lead="What a robot wears: elastic bands, their routes, stiffness and natural length." />
      <HandInDevice />
      <Stack gap="xl" mt="xl">
        <ThingList
          things="devices"
          pages={newest}
          search={{ sought, placeholder: "Name of a device or robot", nothing }}
          none={<NoDevices />}
          row={(device) => <DeviceRow key={device.id} device={device} versions={device.versions} />}
        />
        {devices.data && <DevicesOfStudies devices={devices.data} words={sought.words} />}
      </Stack>
    </>
  );
}

function DeviceRow({ device, versions }: { device: Device; versions: number }) {
  const { bands, groups, joints, robot, warnings } = device.summary;
  const facts = [count(bands.length, "band"), count(groups.length, "group"), `acts on ${count(joints.length, "joint")}`, `on ${robot}`];
  return (
    <ThingRow to={`/devices/${device.id}`} name={device.name} facts={facts.join(" · ")}>
      {warnings.length > 0 && (
        <Badge variant="default" tt="none">
          {count(warnings.length, "doubt")}
        </Badge>
      )}
      <Standing at={device.created_at} version={device.version} of={versions} />
    </ThingRow>
  );
}

function NoDevices() {
  return (
    <Empty title="No devices yet">
      <Text>
        A device is one file, <code>device.yaml</code>: for each band the points of the robot’s links that it passes, and, where
        known, stiffness and natural length.
      </Text>
    </Empty>
  );
}
