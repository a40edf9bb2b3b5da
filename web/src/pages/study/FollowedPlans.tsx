import { Anchor, List, Table, Text, Title } from "@mantine/core";
import { Link } from "react-router";

import { fixed, isNumber, NONE, percent, significant } from "../../parts/digits";
import { number, WideTable } from "../../parts/WideTable";
import type { FollowedPlan } from "./results";

const SHOWN = 5; // joints of a log, those that stray farthest

/** Which logs are of which planned motion, and how far the robot strayed from it. */
export function FollowedPlans({ plans, onPlanPage = false }: { plans: FollowedPlan[]; onPlanPage?: boolean }) {
  const rows = plans.flatMap((plan) => plan.logs.filter((log) => log.state === "follows").map((log) => ({ plan, log })));
  return (
    <>
      <List size="sm" mb="sm">
        {plans.map((plan) => (
          <List.Item key={plan.plan} data-plan={plan.plan}>
            {plan.sentence}{" "}
            {plan.plan_id && !onPlanPage && (
              <Anchor component={Link} to={`/plans/${plan.plan_id}`} inherit underline="always">
                The plan
              </Anchor>
            )}
          </List.Item>
        ))}
      </List>
      {rows.length > 0 && (
        <>
          <WideTable
            label="How far the robot strayed from its plan"
            mostHeight="26rem"
            columns={["Log", "Joint", number("RMS"), number("At most"), number("then", "s of the log"), number("Later", "ms"), number("Plan begins", "s of the log"), number("All joints", "% of the motion")]}
          >
            {rows.flatMap(({ plan, log }) =>
              log.joints.slice(0, SHOWN).map((each, k) => (
                <Table.Tr key={`${plan.plan}|${log.log}|${each.joint}`} data-stray={`${log.log}|${each.joint}`}>
                  <Table.Th scope="row">{k === 0 && log.log}</Table.Th>
                  <Table.Td>{each.joint}</Table.Td>
                  <Table.Td data-number>{angle(each.rms, each.unit)}</Table.Td>
                  <Table.Td data-number>{angle(each.most, each.unit)}</Table.Td>
                  <Table.Td data-number>{isNumber(each.at_s) ? fixed(each.at_s, 2) : NONE}</Table.Td>
                  <Table.Td data-number>{isNumber(each.later_s) ? fixed(1e3 * each.later_s, 0) : NONE}</Table.Td>
                  <Table.Td data-number>{k === 0 && isNumber(log.begins_s) && fixed(log.begins_s, 3)}</Table.Td>
                  <Table.Td data-number>{k === 0 && isNumber(log.share) && percent(log.share, 1)}</Table.Td>
                </Table.Tr>
              )),
            )}
          </WideTable>
          <Text size="xs" c="dimmed" mt={4}>
            The five joints that stray farthest. A log is known again by its joints’ angles, wherever in it the plan begins; the robot’s delay is in that
            moment, and what a joint is later still stands in its row.
          </Text>
        </>
      )}
    </>
  );
}

/** The same with a heading; nothing where no plan was named or known. */
export function FollowedSection({ plans }: { plans: FollowedPlan[] | undefined }) {
  if (!plans?.length) return null;
  return (
    <section aria-labelledby="plans">
      <Title order={2} size="h3" id="plans" mb="xs">
        Planned motions
      </Title>
      <FollowedPlans plans={plans} />
    </section>
  );
}

function angle(value: number | null, unit: "rad" | "m"): string {
  if (!isNumber(value)) return NONE;
  return unit === "m" ? `${significant(1e3 * value, 2)} mm` : `${significant((180 / Math.PI) * value, 2)}°`;
}
