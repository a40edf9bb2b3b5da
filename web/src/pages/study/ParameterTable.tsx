import { Button, Group, Select, Table, Text, TextInput, Title } from "@mantine/core";
import { useDeferredValue, useMemo, useState } from "react";

import { isNumber, percent, significant, unitOf } from "../../parts/digits";
import { count } from "../../parts/size";
import { Uncertain } from "../../parts/Uncertain";
import { number, WideTable } from "../../parts/WideTable";
import { largest } from "./DoubtTable";
import type { DoubtSource, Parameter } from "./results";

const FIRST = 40;
const WHICH = { all: "All", known: "Told by the data", prior: "Told by the prior" } as const;

/** Every parameter, to search; each says whether the data or the prior decided it. */
export function ParameterTable({ parameters, sources }: { parameters: Parameter[]; sources: DoubtSource[] }) {
  const [wanted, setWanted] = useState("");
  const [which, setWhich] = useState<keyof typeof WHICH>("all");
  const [all, setAll] = useState(false);
  const words = useDeferredValue(wanted.trim().toLowerCase());
  const found = useMemo(
    () =>
      parameters.filter(
        ({ name, identifiable }) =>
          name.toLowerCase().includes(words) && (which === "all" || identifiable === (which === "known")),
      ),
    [parameters, words, which],
  );
  const shown = all ? found : found.slice(0, FIRST);
  return (
    <section aria-labelledby="parameters">
      <Title order={2} size="h3" id="parameters" mb="sm">
        Parameters
      </Title>
      <Text size="sm" c="dimmed" mb="xs" style={{ maxWidth: "60rem" }}>
        Of each link m is the mass, mx my mz are mass times centre of mass, Ixx … Izz moments of inertia, all in the link’s own frame;
        of each joint k_T is the torque per ampere, k_d viscous, tau_c Coulomb and tau_s static friction, tau_o a torque offset,
        J_r the rotor’s inertia. ± is one standard deviation.
      </Text>
      <Group gap="sm" align="flex-end" mb="xs">
        <TextInput
          label="Find a parameter"
          placeholder="k_T, torso_pitch, chest …"
          miw={240}
          value={wanted}
          onChange={(event) => setWanted(event.currentTarget.value)}
        />
        <Select
          label="Which"
          allowDeselect={false}
          data={Object.entries(WHICH).map(([value, label]) => ({ value, label }))}
          value={which}
          onChange={(value) => setWhich((value ?? "all") as keyof typeof WHICH)}
        />
        <Text size="sm" c="dimmed" role="status">
          {count(found.length, "parameter")}
          {found.length < parameters.length && ` of ${parameters.length}`}
        </Text>
      </Group>
      <WideTable
        label="Parameters of the robot"
        columns={["Parameter", number("Value ± std"), "Unit", number("Before ± std"), "Decided by"]}
      >
        {shown.map((each) => (
          <Table.Tr key={each.name} data-parameter={each.name}>
            <Table.Th scope="row">
              {each.name}
              {each.combination && (
                <Text size="xs" c="dimmed" fw={400} title={Object.keys(each.combination).join(", ")}>
                  a sum of {count(Object.keys(each.combination).length, "parameter")}
                </Text>
              )}
            </Table.Th>
            <Table.Td data-number>
              <Uncertain value={each.value} std={each.std} />
            </Table.Td>
            <Table.Td>{unitOf(each.unit)}</Table.Td>
            <Table.Td data-number>
              <Uncertain value={each.prior} std={each.prior_std} />
            </Table.Td>
            <Table.Td>
              {decidedBy(each)}
              <Text size="xs" c="dimmed">
                {mostOfTheDoubt(each, sources)}
              </Text>
            </Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      {found.length === 0 && (
        <Text size="sm" c="dimmed">
          No parameter is called so.
        </Text>
      )}
      {found.length > FIRST && (
        <Button mt="xs" variant="default" size="xs" onClick={() => setAll(!all)}>
          {all ? `Only the first ${FIRST}` : `All ${found.length}`}
        </Button>
      )}
    </section>
  );
}

/** Which source makes most of what is left open. */
function mostOfTheDoubt({ budget }: Parameter, sources: DoubtSource[]): string {
  const most = largest(budget);
  const words = sources.find(({ source }) => source === most?.source)?.words;
  return most && words ? `± mostly ${words} (${percent(most.share)})` : "";
}

/** How much the logs narrowed what was believed. */
function decidedBy({ name, identifiable, std, prior_std }: Parameter): string {
  const ratio = isNumber(std) && isNumber(prior_std) && std > 0 ? prior_std / std : null;
  if (identifiable) return ratio !== null && ratio >= 1.05 ? `data: ${significant(ratio, 2)} times surer than before` : "data";
  if (name.startsWith("tau_s")) return "bounded only: friction at rest varies";
  if (ratio === null) return "prior: these motions do not tell it";
  return ratio >= 1.05 ? `mostly prior: data made it ${significant(ratio, 2)} times surer` : "prior: these motions do not tell it";
}
