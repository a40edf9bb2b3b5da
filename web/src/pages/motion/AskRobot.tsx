import { Alert, Anchor, Button, Checkbox, Group, Select, SimpleGrid, Stack, Text, Title } from "@mantine/core";
import { useState } from "react";
import { Link, useNavigate } from "react-router";

import { useCreatePlan, type Motion, type PlanAsked } from "../../api/motions";
import { useRobots, type Robot } from "../../api/robots";
import { figure } from "../../parts/digits";
import { NumberField } from "../../parts/NumberField";
import { ProblemBox } from "../../parts/ProblemBox";

type Options = NonNullable<PlanAsked["retarget"]>;

/** Choose a robot, say how, and ask for the plan. */
export function AskRobot({ motion }: { motion: Motion }) {
  const { data: robots } = useRobots();
  const [robotId, choose] = useState<string | null>(null);
  const [options, set] = useState<Partial<Options>>({});
  const create = useCreatePlan();
  const navigate = useNavigate();
  const robot = robots?.find(({ id }) => id === robotId);
  const ready = (robots ?? []).filter((each) => lacks(each).length === 0);
  const ask = () =>
    create.mutate(
      { robot_id: robotId!, motion_id: motion.id, retarget: options as Options },
      { onSuccess: (plan) => void navigate(`/plans/${plan.id}`) },
    );
  return (
    <section aria-labelledby="robot">
      <Title order={2} size="h3" id="robot" mb="xs">
        As a motion of a robot
      </Title>
      <Stack gap="sm">
        {robots && ready.length === 0 && <NoRobot any={robots.length > 0} />}
        <RobotChoice robots={robots ?? []} value={robotId} choose={choose} />
        {robot && lacks(robot).length > 0 && <Lacking robot={robot} />}
        <details>
          <summary>How</summary>
          <Stack gap="sm" mt="xs">
            <SimpleGrid cols={{ base: 2, sm: 3, md: 6 }}>
              <NumberField label="From [s]" placeholder="0" value={options.begin} set={(begin) => set(put(options, { begin }))} />
              <NumberField label="To [s]" placeholder={figure(motion.summary.seconds)} value={options.end} set={(end) => set(put(options, { end }))} />
              <NumberField label="Times the time" placeholder="1" value={options.slow} set={(slow) => set(put(options, { slow }))} />
              <NumberField label="Repeats" placeholder="1" value={options.repeat} set={(repeat) => set(put(options, { repeat }))} />
              <NumberField
                label="Trunk’s angle [%]"
                placeholder="100"
                value={options.share === undefined ? undefined : 100 * options.share}
                set={(share) => set(put(options, { share: share === undefined ? undefined : share / 100 }))}
              />
              <NumberField
                label="Margin of balance [mm]"
                placeholder="20"
                value={options.margin_m === undefined ? undefined : 1e3 * options.margin_m}
                set={(margin) => set(put(options, { margin_m: margin === undefined ? undefined : margin / 1e3 }))}
              />
              <NumberField label="Rate [Hz]" placeholder="200" value={options.rate_hz} set={(rate_hz) => set(put(options, { rate_hz }))} />
            </SimpleGrid>
            <Group gap="lg">
              <Checkbox label="Left and right exchanged" checked={options.mirror ?? false} onChange={(event) => set(put(options, { mirror: event.currentTarget.checked }))} />
              {(["arms", "pelvis"] as const).map((part) => (
                <Checkbox
                  key={part}
                  label={part === "arms" ? "Ask nothing of the arms" : "Let the pelvis stay"}
                  checked={options.without?.includes(part) ?? false}
                  onChange={(event) => {
                    const others = (options.without ?? []).filter((each) => each !== part);
                    set(put(options, { without: event.currentTarget.checked ? [...others, part] : others }));
                  }}
                />
              ))}
              <Checkbox
                label="Where it cannot be had: find what would do"
                checked={options.what_would_do ?? true}
                onChange={(event) => set(put(options, { what_would_do: event.currentTarget.checked }))}
              />
            </Group>
          </Stack>
        </details>
        <Group>
          <Button disabled={!robotId} loading={create.isPending} onClick={ask}>
            Plan it
          </Button>
        </Group>
        {create.error && <ProblemBox error={create.error} />}
      </Stack>
    </section>
  );
}

export function RobotChoice({ robots, value, choose }: { robots: Robot[]; value: string | null; choose: (id: string | null) => void }) {
  return (
    <Select
      label="Robot"
      maw={420}
      searchable
      placeholder="Choose a robot"
      data={robots.map((robot) => ({ value: robot.id, label: `${robot.name}, version ${robot.version}` }))}
      value={value}
      onChange={choose}
    />
  );
}

/** What of robot.yaml is not there; of a robot handed in before this was told, nothing is known. */
export function lacks({ summary }: Robot): string[] {
  const { motion } = summary;
  if (!motion) return [];
  return [
    ...(summary.base === "floating" ? [] : ["a base that floats"]),
    ...(motion.soles >= 2 ? [] : ["soles"]),
    ...(["pelvis", "thorax"].every((part) => motion.human_map.includes(part)) ? [] : ["human_map with pelvis and thorax"]),
    ...(motion.home ? [] : ["home"]),
  ];
}

function Lacking({ robot }: { robot: Robot }) {
  return (
    <Alert color="orange" variant="default" title="This robot cannot stand for a person yet">
      <Text size="sm">
        Its robot.yaml lacks {lacks(robot).join(", ")}. <code>soles</code> says what its feet stand on, <code>human_map</code> which links are its pelvis,
        thorax and arms, <code>home</code> how it stands. Add them and hand it in again, under{" "}
        <Anchor component={Link} to="/robots" inherit underline="always">
          Robots
        </Anchor>
        .
      </Text>
    </Alert>
  );
}

function NoRobot({ any }: { any: boolean }) {
  return (
    <Alert color="orange" variant="default" title={any ? "No robot here has soles and a human_map" : "There is no robot yet"}>
      <Text size="sm">
        A motion is planned for a robot on two feet, whose robot.yaml has <code>soles</code>, <code>human_map</code> and <code>home</code>. Hand one in under{" "}
        <Anchor component={Link} to="/robots" inherit underline="always">
          Robots
        </Anchor>
        ; <code>exogauge sample my-study</code> writes one that has them.
      </Text>
    </Alert>
  );
}

function put(options: Partial<Options>, change: Partial<Options>): Partial<Options> {
  return Object.fromEntries(Object.entries({ ...options, ...change }).filter(([, value]) => value !== undefined));
}
