import { Anchor, Badge, Group, Stack, Text, Title } from "@mantine/core";
import { useEffect } from "react";
import { Link } from "react-router";

import { useDevices, type Device } from "../../api/devices";
import { Empty } from "../../parts/Empty";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { AtRight, Row, Rows } from "../../parts/Rows";
import { NothingFound, SearchBox } from "../../parts/SearchBox";
import { count } from "../../parts/size";
import { useSought, type Sought } from "../../parts/useSought";
import { When } from "../../parts/When";
import { DevicesOfStudies } from "./DevicesOfStudies";
import { HandInDevice } from "./HandInDevice";

export function Component() {
  const sought = useSought();
  const { data: devices, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useDevices(sought.words ? { search: sought.words } : {});
  useEffect(() => {
    if (hasNextPage && !error && !isFetchingNextPage) void fetchNextPage(); // versions of one device stand together
  }, [hasNextPage, error, isFetchingNextPage, fetchNextPage]);
  return (
    <>
      <PageTitle title="Devices" lead="What a robot wears: elastic bands, their routes, stiffness and natural length." />
      <HandInDevice />
      {error && !devices ? (
        <ProblemBox error={error} retry={() => void refetch()} />
      ) : !devices ? (
        <Loading what="the devices" />
      ) : (
        <Stack gap="xl" mt="xl">
          {devices.length > 0 || sought.words ? <DeviceList devices={devices} sought={sought} /> : <NoDevices />}
          <DevicesOfStudies devices={devices} words={sought.words} />
        </Stack>
      )}
    </>
  );
}

function DeviceList({ devices, sought }: { devices: Device[]; sought: Sought }) {
  const names = [...new Set(devices.map((device) => device.name))];
  return (
    <section aria-labelledby="devices">
      <Group justify="space-between" align="flex-end" mb="sm">
        <Title order={2} size="h3" id="devices">
          Handed in
        </Title>
        <SearchBox what="devices" placeholder="Name of a device or robot" sought={sought} />
      </Group>
      {devices.length === 0 && (
        <NothingFound sentence={`No device has “${sought.words}” in its name or its robot’s.`} clear={sought.clear} />
      )}
      <Rows>
        {names.map((name) => {
          const versions = devices.filter((device) => device.name === name);
          return <DeviceRow key={name} device={versions[0] as Device} versions={versions.length} />;
        })}
      </Rows>
    </section>
  );
}

function DeviceRow({ device, versions }: { device: Device; versions: number }) {
  const { bands, groups, joints, robot, warnings } = device.summary;
  const facts = [count(bands.length, "band"), count(groups.length, "group"), `acts on ${count(joints.length, "joint")}`, `on ${robot}`];
  const words = (
    <>
      <Anchor component={Link} to={`/devices/${device.id}`} fw={600}>
        {device.name}
      </Anchor>
      <Text size="sm" c="dimmed">
        {facts.join(" · ")}
      </Text>
    </>
  );
  return (
    <Row words={words}>
      {warnings.length > 0 && (
        <Badge variant="default" tt="none">
          {count(warnings.length, "doubt")}
        </Badge>
      )}
      <AtRight>
        {versions > 1 ? `version ${device.version} of ${versions}` : "one version"}
        <br />
        <When at={device.created_at} />
      </AtRight>
    </Row>
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
