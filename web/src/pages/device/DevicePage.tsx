import { Anchor, Group, Stack, Title } from "@mantine/core";
import { Link, useParams } from "react-router";

import { useDevice, useDevices, type Device } from "../../api/devices";
import { useTextFile } from "../../api/files";
import { fileAddress, useRobot } from "../../api/robots";
import { DeleteButton } from "../../parts/DeleteButton";
import { FileTable } from "../../parts/FileTable";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { DeviceEditor } from "./DeviceEditor";
import { Doubts } from "./Doubts";

export function Component() {
  const { deviceId = "" } = useParams();
  const device = useDevice(deviceId);
  const robot = useRobot(device.data?.robot_id);
  const text = useTextFile(device.data && fileAddress("devices", device.data.id, "device.yaml"));
  for (const asked of [device, robot, text]) {
    if (asked.error && !asked.data) return <ProblemBox error={asked.error} retry={() => void asked.refetch()} />;
  }
  if (!device.data || !robot.data || text.data === undefined) return <Loading what="the device" lines={6} />;
  return (
    <>
      <PageTitle
        title={device.data.name}
        lead={
          <>
            Version {device.data.version}, worn by{" "}
            <Anchor component={Link} to={`/robots/${robot.data.id}`} underline="always">
              {robot.data.name}
            </Anchor>
          </>
        }
      >
        <Versions device={device.data} />
        <DeleteButton kind="devices" id={device.data.id} name={`${device.data.name}, version ${device.data.version}`}>
          This version goes. Studies keep their own files.
        </DeleteButton>
      </PageTitle>
      <Stack gap="xl">
        <Doubts summary={device.data.summary} />
        <DeviceEditor key={device.data.id} device={device.data} robot={robot.data} text={text.data} />
        <section aria-labelledby="files">
          <Title order={2} size="h3" id="files" mb="sm">
            Files
          </Title>
          <FileTable label="Files of the device" files={device.data.files ?? []} href={(path) => fileAddress("devices", deviceId, path)} />
        </section>
      </Stack>
    </>
  );
}

function Versions({ device }: { device: Device }) {
  const { data: versions = [] } = useDevices({ name: device.name });
  const others = versions.filter((each) => each.id !== device.id);
  if (others.length === 0) return null;
  return (
    <Group gap="xs" component="nav" aria-label="Other versions">
      {others.map((each) => (
        <Anchor key={each.id} component={Link} to={`/devices/${each.id}`}>
          version {each.version}
        </Anchor>
      ))}
    </Group>
  );
}
