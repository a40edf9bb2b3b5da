import { Alert, Anchor, Button, Group, List, Progress, Stack, Text, Title } from "@mantine/core";
import { IconAlertTriangle, IconCircleCheck } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { Link, useParams } from "react-router";

import { usePlan, useStudiesOfPlan, type Plan } from "../../api/motions";
import { isActive, type Study } from "../../api/studies";
import { DeleteButton } from "../../parts/DeleteButton";
import { Loading } from "../../parts/Loading";
import { percent } from "../../parts/digits";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { StateBadge } from "../../parts/StateBadge";
import { useDeed } from "../../parts/useDeed";
import { FilesSection } from "../study/FilesSection";
import { FollowedPlans } from "../study/FollowedPlans";
import { JobTrouble } from "../study/JobTrouble";
import { useCancel, useJob, useRetry } from "../study/jobs";
import { isEvaluation, useResults } from "../study/results";
import { duration } from "../study/words";
import { Certainties } from "./Certainties";
import { Exports } from "./Exports";
import { planWords, toldWords } from "./facts";
import { Margins } from "./Margins";
import { PlanOverTime } from "./OverTime";
import { Trunk } from "./Trunk";

/** One plan: how it stands, what it gives and what binds it, what would do, and its files. */
export function Component() {
  const { planId = "" } = useParams();
  const { data: plan, error, refetch } = usePlan(planId);
  if (error && !plan) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!plan) return <Loading what="the plan" lines={6} />;
  const { found } = plan;
  return (
    <>
      <PageTitle title={plan.name} lead={planWords(plan)}>
        <DeleteButton kind="plans" id={plan.id} name={plan.name}>
          The plan goes, with its files. The robot and the motion stay.
        </DeleteButton>
      </PageTitle>
      <Stack gap="xl">
        <div>
          <Text size="sm">
            For{" "}
            <Anchor component={Link} to={`/robots/${plan.robot_id}`} inherit underline="always">
              {plan.robot}
            </Anchor>
            {plan.motion_id && (
              <>
                , of{" "}
                <Anchor component={Link} to={`/motions/${plan.motion_id}`} inherit underline="always">
                  {plan.motion}
                </Anchor>
              </>
            )}
            .
          </Text>
          {plan.latest_job && <How jobId={plan.latest_job.id} plan={plan} />}
        </div>
        {found && plan.found_job_id && (
          <>
            <Verdict plan={plan} />
            {found.trunk.length > 0 && <Trunk found={found} />}
            <Margins found={found} />
            {found.parameters.length > 0 && <Certainties found={found} />}
            <Exports plan={plan} />
            <PlanOverTime plan={plan} jobId={plan.found_job_id} />
            <Told plan={plan} />
            <Played plan={plan} />
            <Files jobId={plan.found_job_id} />
          </>
        )}
      </Stack>
    </>
  );
}

function How({ jobId, plan }: { jobId: string; plan: Plan }) {
  const { data: job } = useJob(jobId);
  const cancel = useCancel(jobId);
  const retry = useRetry(jobId);
  const cache = useQueryClient();
  const { start, busy, error } = useDeed();
  if (!job) return null;
  const again = async () => {
    await retry.mutateAsync();
    await cache.invalidateQueries({ queryKey: ["plans", plan.id] });
  };
  if (job.state === "succeeded") return null;
  return (
    <div>
      <Group gap="sm" my="xs">
        <StateBadge state={job.state} />
        {isActive(job.state) && (
          <Button size="xs" variant="default" loading={cancel.isPending || job.cancel_requested} onClick={() => cancel.mutate()}>
            Cancel
          </Button>
        )}
        {(job.state === "failed" || job.state === "cancelled") && (
          <Button size="xs" loading={busy} onClick={() => start(again)}>
            Try again
          </Button>
        )}
      </Group>
      {isActive(job.state) && (
        <>
          <Progress value={100 * job.progress} size="sm" aria-label="Progress of the plan" />
          <Text size="sm" role="status" mt={4}>
            {job.state === "queued" ? `In the queue: ${job.place ?? "waiting"}.` : `${percent(job.progress)} ${job.message}`}
          </Text>
        </>
      )}
      <JobTrouble job={job} onLog={null} />
      {error !== null && <ProblemBox error={error} />}
    </div>
  );
}

function Verdict({ plan }: { plan: Plan }) {
  const found = plan.found!;
  if (found.broken.length === 0)
    return (
      <Alert icon={<IconCircleCheck aria-hidden />} color="teal" variant="default" title="Every bound holds">
        <Text size="sm">
          It takes {duration(found.seconds)}.{" "}
          {found.kind !== "excite" && "The ways from home and back are in it. "}
          {found.kind === "excite" ? `Nearest bound: ${String(found.told["nearest bound"] ?? "")}.` : `It was judged at ${found.rate_hz.toFixed(0)} Hz.`}
        </Text>
      </Alert>
    );
  return (
    <Alert icon={<IconAlertTriangle aria-hidden />} color="orange" variant="default" title={found.broken.length === 1 ? "A bound is broken" : `${found.broken.length} bounds are broken`}>
      <List size="sm">
        {found.broken.map((line) => (
          <List.Item key={line}>{line}</List.Item>
        ))}
      </List>
      <WouldDo plan={plan} />
    </Alert>
  );
}

function WouldDo({ plan }: { plan: Plan }) {
  const found = plan.found!;
  if (!found.would_do && plan.request.what_would_do === false)
    return (
      <Text size="sm" mt="xs">
        Ask for it slower, with a smaller share of the trunk’s angle or without the arms; or plan it again with “find what would do”.
      </Text>
    );
  if (!found.would_do) return null;
  const { slower, share } = found.would_do;
  return (
    <Text size="sm" mt="xs" fw={600}>
      What would do: {slower === null ? "no slow-down that was tried" : `${slower.toFixed(2)} times the time`}
      {share === null ? ", nor with the trunk still" : `, or ${percent(share)} of the trunk’s angle`}.
    </Text>
  );
}

/** What other parts of the page show. */
const ELSEWHERE =
  /^(robot|seconds|rounds|trunk .*|centre of pressure|weight on the feet|feet|feet that lift|frame by frame|velocity|torque|acceleration|position|jerk|nearest.*|broken|(base|joint) parameters|undecided|rate_hz)$/;

/** The rest that was told, in the service’s own words. */
function Told({ plan }: { plan: Plan }) {
  const told = Object.entries(plan.found!.told).filter(
    ([key, value]) => !ELSEWHERE.test(key) && !(plan.kind === "retarget" && key === "motion") && (!Array.isArray(value) || value.length > 0),
  );
  if (!told.length) return null;
  return (
    <section aria-labelledby="told">
      <Title order={2} size="h3" id="told" mb="xs">
        Also told
      </Title>
      <List size="sm">
        {told.map(([key, value]) => (
          <List.Item key={key}>
            {toldWords(key)}: {Array.isArray(value) ? value.join(", ") : value}
          </List.Item>
        ))}
      </List>
    </section>
  );
}

function Played({ plan }: { plan: Plan }) {
  const { data: studies } = useStudiesOfPlan(plan.id, true);
  if (!studies?.items.length) return null;
  return (
    <section aria-labelledby="played">
      <Title order={2} size="h3" id="played" mb="xs">
        Studies that played it
      </Title>
      <Stack gap="md">
        {studies.items.map((study) => (
          <InStudy key={study.id} study={study} plan={plan} />
        ))}
      </Stack>
    </section>
  );
}

/** How far the robot strayed there; of a study that holds the plan and was not evaluated yet, its name. */
function InStudy({ study, plan }: { study: Study; plan: Plan }) {
  const job = study.latest_job;
  const { data: results } = useResults(job?.id ?? "", job?.state === "succeeded");
  const motion = plan.artifacts?.find(({ name }) => name === "motion.csv");
  const found = isEvaluation(results) ? (results.plans ?? []).filter(({ sha256 }) => sha256 === motion?.sha256) : [];
  return (
    <div data-played-in={study.id}>
      <Anchor component={Link} to={`/studies/${study.id}`}>
        {study.name}
      </Anchor>
      {found.length > 0 && <FollowedPlans plans={found} onPlanPage />}
    </div>
  );
}

function Files({ jobId }: { jobId: string }) {
  const { data: job } = useJob(jobId);
  return job ? <FilesSection job={job} /> : null;
}
