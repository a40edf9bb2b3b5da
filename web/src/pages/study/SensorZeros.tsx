import { Table, Text, Title } from "@mantine/core";

import { NONE } from "../../parts/digits";
import { count } from "../../parts/size";
import { Uncertain } from "../../parts/Uncertain";
import { numbers, WideTable } from "../../parts/WideTable";
import type { SensorFound } from "./results";

const COMPONENTS = { fx: "Force x", fy: "Force y", fz: "Force z", mx: "Moment x", my: "Moment y", mz: "Moment z" };
const CARRIED = 4;

/** What each force/torque sensor inside the robot reads of nothing, as the logs tell it. */
export function SensorZeros({ sensors }: { sensors: SensorFound[] }) {
  if (sensors.length === 0) return null;
  const undecided = sensors.some(({ zero }) => Object.values(zero).some((each) => !each.identifiable));
  return (
    <section aria-labelledby="zeros">
      <Title order={2} size="h3" id="zeros" mb={4}>
        Zeros of the force/torque sensors
      </Title>
      <Text size="sm" c="dimmed" mb="xs">
        What a sensor would read if it carried nothing, in its own frame.
        {undecided && " In grey: not told by these logs; it stays near what was believed before."}
      </Text>
      <WideTable
        label="Zeros of the force/torque sensors"
        columns={["Sensor", ...numbers(...Object.values(COMPONENTS))]}
      >
        {sensors.map(({ sensor, carries, zero }) => (
          <Table.Tr key={sensor}>
            <Table.Th scope="row">
              {sensor}
              <Text size="xs" c="dimmed" fw={400} title={carries.join(", ")}>
                carries {carries.length > CARRIED ? count(carries.length, "link") : carries.join(", ")}
              </Text>
            </Table.Th>
            {Object.keys(COMPONENTS).map((key) => {
              const found = zero[key];
              return (
                <Table.Td key={key} data-number c={found && !found.identifiable ? "dimmed" : undefined}>
                  {found ? <Uncertain {...found} /> : NONE}
                </Table.Td>
              );
            })}
          </Table.Tr>
        ))}
      </WideTable>
    </section>
  );
}
