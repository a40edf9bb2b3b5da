import { Group, SegmentedControl, Stack, Switch, Title } from "@mantine/core";
import { lazy, Suspense, useMemo, useState } from "react";

import type { Motion, Plan } from "../../api/motions";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { Cursor } from "../../plots/cursor";
import { PlotStack } from "../../plots/PlotStack";
import { useSeries, type Source } from "../../plots/series";
import { useView } from "../../plots/view";
import styles from "../study/PlotsSection.module.css";

const PlanView = lazy(() => import("../../view3d/MotionView").then((module) => ({ default: module.PlanView })));
const CaptureView = lazy(() => import("../../view3d/MotionView").then((module) => ({ default: module.CaptureView })));
const SERIES = "motion";
const ANGLES_FIRST = ["angle.trunk_flexion", "angle.l_hip_flexion", "angle.l_knee_flexion"];
const SHOWN_FIRST = ["head", "pelvis", "l_foot"];

/** What a plan does over time, beside the robot and the person. */
export function PlanOverTime({ plan, jobId }: { plan: Plan; jobId: string }) {
  const trunk = plan.found?.trunk.map(({ joint }) => `trunk.${joint}`) ?? [];
  const widest = [...(plan.found?.trunk ?? [])].sort((one, two) => way(two.asked) - way(one.asked))[0];
  const first = [widest ? `trunk.${widest.joint}` : trunk[0], "human", "margin.pressure_inside", "bounds"].filter((key) => key !== undefined); // those that the series has are shown
  return (
    <Shown
      source={{ of: "jobs", id: jobId }}
      first={first}
      stage={(cursor) => <PlanView planId={plan.id} jobId={jobId} name={plan.name} cursor={cursor} />}
    />
  );
}

/** A capture over time, beside the person. */
export function CaptureOverTime({ motion }: { motion: Motion }) {
  const about = motion.latest_job?.state === "succeeded" ? motion.latest_job.id : "";
  const kind = motion.summary.holds === "markers" ? "marker" : "bone";
  const labelled = (part: string) => motion.summary.labels?.find(({ segment }) => segment === part)?.name;
  const first = SHOWN_FIRST.flatMap((part) => labelled(part) ?? []).map((label) => `${kind}.${label}`);
  const [captured, showCaptured] = useState(false);
  const fitted = about !== "" && !captured;
  return (
    <>
      {about !== "" && (
        <SegmentedControl
          aria-label="What is shown over time"
          data={[
            { value: "fitted", label: "Angles of the fitted body" },
            { value: "captured", label: "As captured" },
          ]}
          value={fitted ? "fitted" : "captured"}
          onChange={(value) => showCaptured(value === "captured")}
        />
      )}
      <Shown
        key={fitted ? about : motion.id}
        source={fitted ? { of: "jobs", id: about } : { of: "motions", id: motion.id }}
        first={fitted ? ANGLES_FIRST : first}
        stage={(cursor) => <CaptureView motionId={motion.id} about={about} name={motion.name} cursor={cursor} />}
      />
    </>
  );
}

type Props = { source: Source; first: string[]; stage: (cursor: Cursor) => React.ReactNode };

function Shown({ source, first, stage }: Props) {
  const [view, change] = useView();
  const { data: series, error, refetch } = useSeries(source, SERIES);
  const cursor = useMemo(() => new Cursor(view.at), [source.id]);
  return (
    <section aria-labelledby="over-time">
      <Group justify="space-between" mb="xs">
        <Title order={2} size="h3" id="over-time">
          Over time
        </Title>
        <Switch size="sm" label="In 3D" checked={view.robot} onChange={(event) => change({ robot: event.currentTarget.checked })} />
      </Group>
      <Stack gap="md">
        {error && <ProblemBox error={error} retry={() => void refetch()} />}
        <div className={styles.sides} data-robot={view.robot || undefined}>
          {view.robot && (
            <div className={styles.robot}>
              <Suspense fallback={<Loading what="the 3D view" />}>{stage(cursor)}</Suspense>
            </div>
          )}
          {series ? (
            <PlotStack source={source} series={series} view={view} first={first} cursor={cursor} motion onView={change} />
          ) : (
            !error && <Loading what="the series" />
          )}
        </div>
      </Stack>
    </section>
  );
}

function way([low = 0, high = 0]: number[]): number {
  return high - low;
}
