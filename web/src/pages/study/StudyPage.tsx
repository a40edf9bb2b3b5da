import { Group } from "@mantine/core";
import { useParams } from "react-router";

import { useStudy } from "../../api/studies";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { StateBadge } from "../../parts/StateBadge";

export function Component() {
  const { studyId = "" } = useParams();
  const { data: study, error, refetch } = useStudy(studyId);
  if (error && !study) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!study) return <Loading what="the study" />;
  return (
    <>
      <PageTitle title={study.name}>
        <StateBadge state={study.latest_job?.state} />
      </PageTitle>
      {study.latest_job?.problem && <ProblemBox problem={study.latest_job.problem} />}
      <Group />
    </>
  );
}
