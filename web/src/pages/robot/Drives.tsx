import { Anchor, Group, NativeSelect, Switch, Table, Text, Title } from "@mantine/core";
import { useState } from "react";
import { Link } from "react-router";

import { useStudyResults, type Found } from "../../api/results";
import type { Robot, RobotJoint } from "../../api/robots";
import { useEveryStudy, type Study } from "../../api/studies";
import { ProblemBox } from "../../parts/ProblemBox";
import { plusMinus } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import styles from "./Drives.module.css";

const VALUES = [
  ["k_T", "Torque per ampere", "N·m/A"],
  ["k_d", "Viscous friction", "N·m·s/rad"],
  ["tau_c", "Coulomb friction", "N·m"],
  ["tau_s", "Static friction", "N·m"],
  ["tau_o", "Offset", "N·m"],
  ["J_r", "Rotor inertia, at the joint", "kg·m²"],
] as const;

/** Drive values as the maker says, and beside them what a study with this robot identified. */
export function Drives({ robot, joints }: { robot: Robot; joints: RobotJoint[] }) {
  const { studies } = useEveryStudy({ robot_id: robot.id, state: "succeeded" });
  const [chosen, choose] = useState("");
  const [onlyMoved, setOnlyMoved] = useState(false);
  const study = studies.find((each) => each.id === chosen) ?? studies[0];
  const results = useStudyResults(study?.id);
  const found = new Map(results.data?.identification.joints.map((each) => [each.joint, each]));
  const identifiable = (joint: string) => VALUES.some(([key]) => found.get(joint)?.[key]?.identifiable);
  const shown = onlyMoved ? joints.filter((joint) => identifiable(joint.name)) : joints;
  const columns = VALUES.filter(([key]) => joints.some((joint) => joint.prior[key] !== undefined || found.get(joint.name)?.[key]));
  return (
    <section aria-labelledby="drives">
      <Group justify="space-between" align="flex-end" mb="sm">
        <Title order={2} size="h3" id="drives">
          Drives and friction
        </Title>
        {study && (
          <Group gap="md" align="flex-end">
            <Switch
              label="Only joints that the logs decide"
              checked={onlyMoved}
              onChange={(event) => setOnlyMoved(event.currentTarget.checked)}
            />
            <NativeSelect
              label="Identified in"
              value={study.id}
              onChange={(event) => choose(event.currentTarget.value)}
              data={studies.map((each) => ({ value: each.id, label: each.name }))}
            />
          </Group>
        )}
      </Group>
      {results.error && <ProblemBox error={results.error} retry={() => void results.refetch()} />}
      {columns.length === 0 ? (
        <Text>robot.yaml says nothing of drives; everything is identified from the logs.</Text>
      ) : (
        <WideTable
          label="Drives and friction"
          mostHeight="32rem"
          columns={["Joint", ...columns.map(([, name, unit]) => number(name, unit))]}
        >
          {shown.map((joint) => (
            <Table.Tr key={joint.name}>
              <Table.Th scope="row">{joint.name}</Table.Th>
              {columns.map(([key]) => (
                <Table.Td key={key} data-number>
                  {joint.prior[key] === undefined && joint.actuation === "torque" && key === "k_T" ? "1, known" : plusMinus(joint.prior[key], joint.prior_std[key])}
                  <Identified of={found.get(joint.name)?.[key]} />
                </Table.Td>
              ))}
            </Table.Tr>
          ))}
        </WideTable>
      )}
      <Text size="sm" c="dimmed" mt="xs">
        The maker’s values with their standard deviation, where robot.yaml gives them.{" "}
        {study ? <Below study={study} /> : "Once a study with this robot is evaluated, what it identified stands below them."}
      </Text>
    </section>
  );
}

function Identified({ of }: { of: Found | undefined }) {
  if (!of || of.value === null) return null;
  return (
    <div className={styles.identified} data-decided={of.identifiable || undefined}>
      {of.identifiable ? plusMinus(of.value, of.std) : "not decided"}
    </div>
  );
}

function Below({ study }: { study: Study }) {
  return (
    <>
      In bold below them: identified in{" "}
      <Anchor component={Link} to={`/studies/${study.id}`} inherit underline="always">
        {study.name}
      </Anchor>
      , which has these very files. “Not decided”: the prior says more than the logs.
    </>
  );
}
