import { Anchor, Text } from "@mantine/core";
import { useCallback } from "react";
import { Link, useParams, useSearchParams } from "react-router";

import { useStudy } from "../../api/studies";
import { DeleteButton } from "../../parts/DeleteButton";
import { SharedBy } from "../../parts/ForMembers";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { JobBar } from "./JobBar";
import { JobTrouble } from "./JobTrouble";
import { NoJob } from "./NoJob";
import { Pipeline } from "./Pipeline";
import { PublishButton } from "./PublishButton";
import { ShareButton } from "./ShareButton";
import { Section } from "./Section";
import { SectionNav } from "./SectionNav";
import { useJob, useJobs, type Job } from "./jobs";
import { useResults } from "./results";
import { sectionsFor } from "./sections";
import { stagesOf } from "./stages";
import { StudyFacts } from "./StudyFacts";
import { summaryOf } from "./summary";
import type { Study } from "../../api/studies";

const EVALUATES = ["evaluate", "support", "stiffness"];

export function Component() {
  const { studyId = "" } = useParams();
  const study = useStudy(studyId);
  const jobs = useJobs(studyId);
  if (study.error && !study.data) return <ProblemBox error={study.error} retry={() => void study.refetch()} />;
  if (jobs.error && !jobs.data) return <ProblemBox error={jobs.error} retry={() => void jobs.refetch()} />;
  if (!study.data || !jobs.data) return <Loading what="the study" />;
  const done = jobs.data.items.find((job) => job.state === "succeeded" && EVALUATES.includes(job.kind));
  return (
    <SharedBy value={study.data.shared_by ?? null}>
      <PageTitle title={study.data.name} lead={<StudyFacts summary={summaryOf(study.data)} />}>
        {done && <PublishButton id={study.data.id} name={study.data.name} jobId={done.id} />}
        <ShareButton id={study.data.id} name={study.data.name} />
        <DeleteButton kind="studies" id={study.data.id} name={study.data.name}>
          Its files, jobs and results go. Robots, devices and logs in the lists stay.
        </DeleteButton>
      </PageTitle>
      {jobs.data.items.length ? <Review study={study.data} jobs={jobs.data.items} /> : <NoJob study={study.data} />}
    </SharedBy>
  );
}

/** One job of the study: the address names it, else it is the newest. */
function Review({ study, jobs }: { study: Study; jobs: Job[] }) {
  const [search, setSearch] = useSearchParams();
  const wanted = search.get("job") ?? jobs[0]!.id;
  const found = useJob(wanted);
  const choose = useCallback(
    (id: string) => setSearch(id === jobs[0]!.id ? {} : { job: id }, { preventScrollReset: true }),
    [setSearch, jobs],
  );
  if (found.error && !found.data) return <ProblemBox error={found.error} retry={() => void found.refetch()} />;
  const job = found.data;
  if (!job) return <Loading what="the job" />;
  const listed = jobs.some((each) => each.id === job.id) ? jobs : [job, ...jobs];
  return (
    <>
      <JobBar job={job} jobs={listed.map((each) => (each.id === job.id ? job : each))} onChoose={choose} />
      <Outcome study={study} job={job} />
    </>
  );
}

function Outcome({ study, job }: { study: Study; job: Job }) {
  const { "*": rest = "" } = useParams();
  const [search] = useSearchParams();
  const succeeded = job.state === "succeeded";
  const { data: results, error, refetch } = useResults(job.id, succeeded);
  const sections = sectionsFor(job, results);
  const wanted = rest.split("/")[0] || sections[0]!.key;
  const section = sections.find((each) => each.key === wanted);
  const log = (
    <Anchor component={Link} inherit underline="always" to={{ pathname: `/studies/${study.id}/run`, search: search.toString() }}>
      Log and raw data
    </Anchor>
  );
  return (
    <>
      <JobTrouble job={job} onLog={log} />
      {!succeeded && wanted !== "run" && <Pipeline stages={stagesOf(job, summaryOf(study))} />}
      {error && <ProblemBox error={error} retry={() => void refetch()} />}
      <SectionNav studyId={study.id} sections={sections} present={section?.key ?? ""} />
      {succeeded && !results && !error && <Loading what="the results" />}
      {section && (results || !succeeded) && <Section name={section.key} study={study} job={job} results={results} />}
      {!section && (results || !succeeded) && (
        <Text>This job has no part “{wanted}”. What there is stands above.</Text>
      )}
    </>
  );
}
