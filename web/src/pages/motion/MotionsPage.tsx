import { Anchor, Button, Group, Stack, Text, Title } from "@mantine/core";
import { Link } from "react-router";

import { useMotionPlans, useMotions, type Motion, type Plan } from "../../api/motions";
import { Empty } from "../../parts/Empty";
import { LinkButton } from "../../parts/LinkButton";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { AtRight, Row, Rows } from "../../parts/Rows";
import { NothingFound, SearchBox } from "../../parts/SearchBox";
import { StateBadge } from "../../parts/StateBadge";
import { useSought } from "../../parts/useSought";
import { When } from "../../parts/When";
import { factsOf, planWords } from "./facts";
import { HandInMotion } from "./HandInMotion";

/** What was captured of people, and what is planned for robots. */
export function Component() {
  const sought = useSought();
  const { data: motions, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useMotions(sought.words);
  return (
    <>
      <PageTitle title="Motions" lead="What a person did, as a motion that a robot can do; and motions from which a robot is identified.">
        <LinkButton to="/plans/new" variant="default">
          Plan a motion that identifies
        </LinkButton>
      </PageTitle>
      <Stack gap="xl">
        <HandInMotion />
        {error && !motions ? (
          <ProblemBox error={error} retry={() => void refetch()} />
        ) : !motions ? (
          <Loading what="the motions" />
        ) : motions.length === 0 && !sought.words ? (
          <Empty title="No motions yet">
            <Text>Drop a capture above: C3D or TRC of markers, BVH or AMC of a skeleton.</Text>
          </Empty>
        ) : (
          <section aria-labelledby="motions">
            <Group justify="space-between" align="flex-end" mb="sm">
              <Title order={2} size="h3" id="motions">
                Handed in
              </Title>
              <SearchBox what="motions" placeholder="Name of a motion" sought={sought} />
            </Group>
            {motions.length === 0 && <NothingFound sentence={`No motion has “${sought.words}” in its name.`} clear={sought.clear} />}
            <Rows>
              {motions.map((motion) => (
                <MotionRow key={motion.id} motion={motion} />
              ))}
            </Rows>
            {hasNextPage && (
              <Button variant="default" mt="sm" onClick={() => void fetchNextPage()} loading={isFetchingNextPage}>
                Show older motions
              </Button>
            )}
          </section>
        )}
        <PlanList title="Plans" of={{}} />
      </Stack>
    </>
  );
}

function MotionRow({ motion }: { motion: Motion }) {
  const words = (
    <>
      <Anchor component={Link} to={`/motions/${motion.id}`} fw={600}>
        {motion.name}
      </Anchor>
      <Text size="sm" c="dimmed">
        {factsOf(motion).join(" · ")}
      </Text>
    </>
  );
  return (
    <Row words={words}>
      <AtRight>
        version {motion.version}
        <br />
        <When at={motion.created_at} />
      </AtRight>
    </Row>
  );
}

/** Plans, newest first. of: those of one motion. */
export function PlanList({ title, of }: { title: string; of: { motion_id?: string } }) {
  const { data: plans, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } = useMotionPlans(of);
  if (error && !plans) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!plans) return <Loading what="the plans" lines={1} />;
  if (!plans.length) return null;
  return (
    <section aria-labelledby="plans">
      <Title order={2} size="h3" id="plans" mb="sm">
        {title}
      </Title>
      <Rows>
        {plans.map((plan) => (
          <PlanRow key={plan.id} plan={plan} />
        ))}
      </Rows>
      {hasNextPage && (
        <Button variant="default" mt="sm" onClick={() => void fetchNextPage()} loading={isFetchingNextPage}>
          Show older plans
        </Button>
      )}
    </section>
  );
}

function PlanRow({ plan }: { plan: Plan }) {
  const job = plan.latest_job;
  const words = (
    <>
      <Anchor component={Link} to={`/plans/${plan.id}`} fw={600}>
        {plan.name}
      </Anchor>
      <Text size="sm" c="dimmed">
        {planWords(plan)}
      </Text>
      {job?.state === "failed" && job.reason && (
        <Text size="sm" lineClamp={2}>
          {job.reason}
        </Text>
      )}
    </>
  );
  return (
    <Row words={words}>
      <StateBadge state={job?.state} />
      <AtRight>
        <When at={plan.created_at} />
      </AtRight>
    </Row>
  );
}
