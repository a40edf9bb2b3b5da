import { List, Text, Title } from "@mantine/core";

import { count } from "../../parts/size";
import type { Identification } from "./results";

const MOST = 12;
const WORDS: Record<string, string> = {
  m: "mass",
  mx: "first moment of mass, x",
  my: "first moment of mass, y",
  mz: "first moment of mass, z",
  k_T: "motor constant",
  k_d: "viscous friction",
  tau_c: "Coulomb friction",
  tau_s: "static friction (a lower bound: friction at rest need not take its largest value)",
  tau_o: "torque offset",
  J_r: "inertia of the rotor",
};

/** What the logs cannot decide, said plainly, by kind of parameter. */
export function Unknowns({ found }: { found: Identification }) {
  const kinds = new Map<string, string[]>();
  for (const name of found.unidentifiable) {
    const [, head = name, place = ""] = /^(.+?)\[(.+)\]$/.exec(name) ?? [];
    if (head === "base") continue; // sums of those that are named here
    const kind = /^I?[xyz]{2}$/.test(head) || head.startsWith("I") ? "moments of inertia" : (WORDS[head] ?? head.replace(/^zero\.(.+)$/, "zero of the sensor, $1"));
    kinds.set(kind, [...new Set([...(kinds.get(kind) ?? []), place || name])]);
  }
  const sums = found.parameters.filter((each) => each.combination);
  const known = sums.filter((each) => each.identifiable).length;
  const impossible = Object.entries(found.consistent_links).filter(([, possible]) => !possible);
  return (
    <section aria-labelledby="unknown">
      <Title order={2} size="h3" id="unknown">
        What these logs cannot tell
      </Title>
      {kinds.size === 0 ? (
        <Text size="sm">The logs decide every parameter.</Text>
      ) : (
        <>
          <Text size="sm" mb="xs">
            For these the value is mostly what was believed before. {sums.length > 0 && `Of their sums that the motion can feel at all, ${count(known, "is", "are")} known better by the logs than before, of ${sums.length}. `}
            A richer motion tells more of them apart.
          </Text>
          <List size="sm" spacing={2}>
            {[...kinds].map(([kind, places]) => (
              <List.Item key={kind}>
                <strong>{kind}</strong>: {places.slice(0, MOST).join(", ")}
                {places.length > MOST && ` and ${places.length - MOST} more`}
              </List.Item>
            ))}
          </List>
        </>
      )}
      {impossible.length > 0 && (
        <Text size="sm" mt="xs">
          No body can have the inertial parameters found for {impossible.map(([link]) => link).join(", ")}: they predict well as
          sums, and not one by one. The setting <code>consistency: physical</code> asks for possible ones.
        </Text>
      )}
    </section>
  );
}
