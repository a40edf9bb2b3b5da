import { MultiSelect, SimpleGrid, Text } from "@mantine/core";

import { useBandLaws, type BandLaw } from "../../api/devices";
import { figure } from "../../parts/digits";
import { NumberField } from "../../parts/NumberField";
import { ProblemBox } from "../../parts/ProblemBox";
import { groupOf, lawsOf, LINEAR, ownValues, type DeviceContent } from "./deviceFile";
import { withLaw, withLawValue } from "./edits";

type Props = { device: DeviceContent; group: string; set: (next: DeviceContent, mark: string) => void };
type Value = BandLaw["values"][number];

/** How the bands of a group pull beyond the spring: none, one or several laws, each with its values. */
export function BandLawForm({ device, group, set }: Props) {
  const asked = useBandLaws();
  if (asked.error && !asked.data) return <ProblemBox error={asked.error} retry={() => void asked.refetch()} />;
  const known = (asked.data ?? []).filter((law) => law.name !== LINEAR);
  const names = lawsOf(device, group);
  const laws = known.filter((law) => names.includes(law.name));
  const values = device.bands.find((band) => groupOf(band) === group)?.law_values ?? {};
  return (
    <>
      <MultiSelect
        label="Law"
        description="How it pulls beside the spring; none: in proportion to its stretch."
        placeholder={names.length === 0 ? LINEAR : undefined}
        data={known.map((law) => ({ value: law.name, label: law.name.replaceAll("_", " ") }))}
        value={names}
        onChange={(chosen) => set(withLaw(device, group, known.filter((law) => chosen.includes(law.name))), `law ${group}`)}
        disabled={!asked.data}
        clearable
      />
      {laws.map((law) => (
        <Text size="sm" key={law.name}>
          {law.sentence}
        </Text>
      ))}
      <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="sm">
        {ownValues(laws).map((each) => (
          <NumberField
            key={each.name}
            label={`${each.name.replaceAll("_", " ")}${each.unit === "1" ? "" : ` [${each.unit}]`}`}
            description={`${each.words}; ${range(each)}`}
            value={values[each.name] ?? each.default}
            error={wrong(each, values[each.name] ?? each.default)}
            set={(value) => value !== undefined && set(withLawValue(device, group, each.name, value), `law ${group} ${each.name}`)}
          />
        ))}
      </SimpleGrid>
    </>
  );
}

function range({ low, high, typical }: Value): string {
  const ends = high === null ? `${figure(low)} or more` : `${figure(low)} to ${figure(high)}`;
  return `${ends}, usual ${figure(typical)}`;
}

/** What the service would refuse. */
function wrong({ low, high }: Value, value: number | null | undefined): string | undefined {
  if (value === null || value === undefined) return "It must be given.";
  if (value < low) return `It must be ${figure(low)} or more.`;
  if (high !== null && value > high) return `It must be ${figure(high)} or less.`;
  return undefined;
}
