import { Anchor, Badge, Paper, Stack, Text, Title } from "@mantine/core";
import { useEffect } from "react";
import { Link } from "react-router";

import { useDevices, type Device } from "../../api/devices";
import { Empty } from "../../parts/Empty";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { count } from "../../parts/size";
import { When } from "../../parts/When";
import styles from "./DeviceList.module.css";
import { DevicesOfStudies } from "./DevicesOfStudies";
import { HandInDevice } from "./HandInDevice";

export function Component() {
  const { data: devices, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useDevices();
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
          {devices.length > 0 ? <DeviceList devices={devices} /> : <NoDevices />}
          <DevicesOfStudies devices={devices} />
        </Stack>
      )}
    </>
  );
}

function DeviceList({ devices }: { devices: Device[] }) {
  const names = [...new Set(devices.map((device) => device.name))];
  return (
    <section aria-labelledby="devices">
      <Title order={2} size="h3" id="devices" mb="sm">
        Handed in
      </Title>
      <ul className={styles.list}>
        {names.map((name) => {
          const versions = devices.filter((device) => device.name === name);
          return <DeviceRow key={name} device={versions[0] as Device} versions={versions.length} />;
        })}
      </ul>
    </section>
  );
}

function DeviceRow({ device, versions }: { device: Device; versions: number }) {
  const { bands, groups, joints, robot, warnings } = device.summary;
  const facts = [count(bands.length, "band"), count(groups.length, "group"), `acts on ${count(joints.length, "joint")}`, `on ${robot}`];
  return (
    <Paper withBorder component="li" className={styles.row}>
      <div>
        <Anchor component={Link} to={`/devices/${device.id}`} fw={600}>
          {device.name}
        </Anchor>
        <Text size="sm" c="dimmed">
          {facts.join(" · ")}
        </Text>
      </div>
      {warnings.length > 0 && (
        <Badge variant="default" tt="none">
          {count(warnings.length, "doubt")}
        </Badge>
      )}
      <Text size="sm" c="dimmed" className={styles.right}>
        {versions > 1 ? `version ${device.version} of ${versions}` : "one version"}
        <br />
        <When at={device.created_at} />
      </Text>
    </Paper>
  );
}

function NoDevices() {
  return (
    <Empty title="No devices yet">
      <Text>
        A device is one file, <code>device.yaml</code>: for each band the points of the robot’s links that it passes, and, where
        known, stiffness and natural length. Drop one above, or take one over from a study.
      </Text>
    </Empty>
  );
}
