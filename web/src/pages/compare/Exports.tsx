import { Anchor, Group, Text } from "@mantine/core";

import { exportAddress } from "../../api/compare";
import styles from "./Matrix.module.css";

/** The tables to take away. */
export function Exports({ jobs }: { jobs: string[] }) {
  return (
    <Group gap="md" className={styles.controls}>
      <Text size="sm">Take away:</Text>
      {(["support", "stiffness"] as const).map((table) =>
        (["csv", "latex"] as const).map((format) => (
          <Anchor key={table + format} href={exportAddress(jobs, format, table)} download size="sm">
            {table === "support" ? "supporting torque" : "stiffness"} as {format === "csv" ? "CSV" : "LaTeX"}
          </Anchor>
        )),
      )}
    </Group>
  );
}
