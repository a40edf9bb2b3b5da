import { Stack, Table, Text, Title } from "@mantine/core";

import type { RobotModel } from "../../api/robots";
import { FactList } from "../../parts/FactList";
import { figure, fixed } from "../../parts/digits";
import { WideTable } from "../../parts/WideTable";

const SEES: Record<string, string> = {
  world_on_robot: "what the world does to the robot",
  robot_on_world: "what the robot does to the world",
  payload_on_sensor: "what the payload does to the sensor",
  sensor_on_payload: "what the sensor does to the payload",
};
const NOISE: [string, string, string][] = [
  ["q", "positions", "rad"],
  ["i", "currents", "A"],
  ["tau", "torques", "N·m"],
  ["acc", "accelerometer", "m/s²"],
  ["gyro", "gyro", "rad/s"],
  ["force", "forces", "N"],
  ["moment", "moments", "N·m"],
];

export function SensorTable({ model }: { model: RobotModel }) {
  const { imu, sensors, noise } = model;
  const known = NOISE.filter(([kind]) => noise[kind] !== undefined);
  return (
    <Stack component="section" gap="sm" aria-labelledby="sensors">
      <Title order={2} size="h3" id="sensors">
        Sensors
      </Title>
      <FactList
        facts={[
          ["IMU", imu ? `${imu.on}, at ${imu.at.map((each) => fixed(each, 3)).join(", ")} m of ${model.base_link}` : "none is used: the base is fixed"],
          ["Noise of one sample", known.map(([kind, words, unit]) => `${words} ${figure(noise[kind], 2)} ${unit}`).join(", ") || "not said; it is estimated from the logs"],
        ]}
      />
      {sensors.length > 0 ? (
        <WideTable label="Force/torque sensors" columns={["Force/torque sensor", "Frame", "Sees", "Used as"]}>
          {sensors.map((sensor) => (
            <Table.Tr key={sensor.name}>
              <Table.Th scope="row">{sensor.name}</Table.Th>
              <Table.Td>{sensor.frame}</Table.Td>
              <Table.Td>{SEES[sensor.sees] ?? sensor.sees}</Table.Td>
              <Table.Td>{sensor.role === "contact" ? "the contact with the outside" : "a cut through the robot"}</Table.Td>
            </Table.Tr>
          ))}
        </WideTable>
      ) : (
        <Text>No force/torque sensors.</Text>
      )}
    </Stack>
  );
}
