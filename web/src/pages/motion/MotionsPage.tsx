import { Stack, Text } from "@mantine/core";

import { useMotionPlans, useMotions } from "../../api/motions";
import { Empty } from "../../parts/Empty";
import { LinkButton } from "../../parts/LinkButton";
import { PageTitle } from "../../parts/PageTitle";
import { Standing, ThingList, ThingRow } from "../../parts/ThingList";
import { useSought } from "../../parts/useSought";
import { factsOf, planWords } from "./facts";
import { HandInMotion } from "./HandInMotion";

/** What was captured of people, and what is planned for robots. */
export function Component() {
  const sought = useSought();
  const motions = useMotions(sought.words);
  return (
    <>
      <PageTitle title="Motions" lead="What a person did, as a motion that a robot can do; and motions from which a robot is identified.">
        <LinkButton to="/plans/new" variant="default">
          Plan a motion that identifies
        </LinkButton>
      </PageTitle>
      <Stack gap="xl">
        <HandInMotion />
        <ThingList
          things="motions"
          pages={motions}
          search={{ sought, placeholder: "Name of a motion", nothing: `No motion has “${sought.words}” in its name.` }}
          none={<NoMotions />}
          row={(motion) => (
            <ThingRow key={motion.id} to={`/motions/${motion.id}`} name={motion.name} facts={factsOf(motion).join(" · ")}>
              <Standing at={motion.created_at} version={motion.version} />
            </ThingRow>
          )}
        />
        <PlanList title="Plans" of={{}} />
      </Stack>
    </>
  );
}

/** Plans, newest first. of: those of one motion. */
export function PlanList({ title, of }: { title: string; of: { motion_id?: string } }) {
  return (
    <ThingList
      things="plans"
      title={title}
      pages={useMotionPlans(of)}
      none={null}
      row={(plan) => (
        <ThingRow key={plan.id} to={`/plans/${plan.id}`} name={plan.name} facts={planWords(plan)} job={plan.latest_job ?? null}>
          <Standing at={plan.created_at} job={plan.latest_job ?? null} />
        </ThingRow>
      )}
    />
  );
}

function NoMotions() {
  return (
    <Empty title="No motions yet">
      <Text>Drop a capture above: C3D, TRC, TSV or CSV of markers, BVH, MVNX or AMC of a skeleton.</Text>
    </Empty>
  );
}
