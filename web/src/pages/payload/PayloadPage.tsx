import { Button, Stack, Text, Title } from "@mantine/core";
import { useCallback } from "react";
import { useParams, useSearchParams } from "react-router";

import { usePayload, usePayloadJobs, usePayloadResults, type Payload } from "../../api/payloads";
import { fileAddress } from "../../api/robots";
import { useSubmitJob } from "../../api/studies";
import { DeleteButton } from "../../parts/DeleteButton";
import { Empty } from "../../parts/Empty";
import { FileTable } from "../../parts/FileTable";
import { LinkButton } from "../../parts/LinkButton";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";
import { FilesSection } from "../study/FilesSection";
import { JobBar } from "../study/JobBar";
import { JobTrouble } from "../study/JobTrouble";
import { useJob, type Job } from "../study/jobs";
import { Pipeline } from "../study/Pipeline";
import { Exports } from "./Exports";
import { factsOf, identifies } from "./facts";
import { In3D } from "./In3D";
import { Live } from "./Live";
import { PayloadFindings } from "./PayloadFindings";
import { Plans } from "./Plans";
import { Results } from "./Results";
import { stagesOf } from "./stages";

export function Component() {
  const { payloadId = "" } = useParams();
  const payload = usePayload(payloadId);
  const jobs = usePayloadJobs(payloadId);
  if (payload.error && !payload.data) return <ProblemBox error={payload.error} retry={() => void payload.refetch()} />;
  if (jobs.error && !jobs.data) return <ProblemBox error={jobs.error} retry={() => void jobs.refetch()} />;
  if (!payload.data || !jobs.data) return <Loading what="the payload" />;
  const found = payload.data;
  return (
    <>
      <PageTitle title={found.name} lead={[...factsOf(found), `version ${found.version}`].join(" · ")}>
        <ForMembers>
          <LinkButton variant="default" to={`/payloads/new?from=${found.id}`}>
            Change or add logs
          </LinkButton>
        </ForMembers>
        <DeleteButton kind="payloads" id={found.id} name={`${found.name}, version ${found.version}`}>
          This version goes, with its files, jobs, results and streams.
        </DeleteButton>
      </PageTitle>
      <Stack gap="xl">
        {identifies(found) && (jobs.data.length ? <Identified payload={found} jobs={jobs.data} /> : <NotYet payload={found} refetch={jobs.refetch} />)}
        {found.summary.findings && found.summary.logs.length > 0 && <PayloadFindings findings={found.summary.findings} />}
        {found.summary.plan && <Plans payload={found} />}
        <Live payload={found} />
        {found.summary.pose === "joints" && <In3D payload={found} />}
        <section aria-labelledby="handed-in">
          <Title order={2} size="h3" id="handed-in" mb="sm">
            Files handed in
          </Title>
          <FileTable label="Files handed in" files={found.files ?? []} href={(path) => fileAddress("payloads", found.id, path)} />
        </section>
      </Stack>
    </>
  );
}

/** One job of the payload: the address names it, else it is the newest. */
function Identified({ payload, jobs }: { payload: Payload; jobs: Job[] }) {
  const [search, setSearch] = useSearchParams();
  const wanted = search.get("job") ?? jobs[0]!.id;
  const found = useJob(wanted);
  const job = found.data;
  const succeeded = job?.state === "succeeded";
  const results = usePayloadResults(wanted, succeeded);
  const choose = useCallback(
    (id: string) => setSearch(id === jobs[0]!.id ? {} : { job: id }, { preventScrollReset: true }),
    [setSearch, jobs],
  );
  if (found.error && !job) return <ProblemBox error={found.error} retry={() => void found.refetch()} />;
  if (!job) return <Loading what="the job" />;
  const newest = jobs.find((each) => each.state === "succeeded")?.id === job.id;
  return (
    <>
      <div>
        <JobBar job={job} jobs={jobs.map((each) => (each.id === job.id ? job : each))} onChoose={choose} />
        <JobTrouble job={job} onLog={null} />
        {!succeeded && <Pipeline stages={stagesOf(job, payload)} />}
        {results.error && <ProblemBox error={results.error} retry={() => void results.refetch()} />}
      </div>
      {succeeded && !results.data && !results.error && <Loading what="the results" />}
      {results.data && (
        <>
          <Results payload={payload} results={results.data} />
          {newest && <Exports payload={payload} results={results.data} />}
          <FilesSection job={job} />
        </>
      )}
    </>
  );
}

function NotYet({ payload, refetch }: { payload: Payload; refetch: () => Promise<unknown> }) {
  const submit = useSubmitJob();
  const { start, busy, error } = useDeed();
  const identify = async () => {
    await submit.mutateAsync({ payload_id: payload.id, kind: "payload", settings: {} });
    await refetch();
  };
  return (
    <Empty title="Not identified yet">
      <Text>The files were read and are in order.</Text>
      <ForMembers told>
        <Button loading={busy} onClick={() => start(identify)}>
          Identify
        </Button>
      </ForMembers>
      {error !== null && <ProblemBox error={error} />}
    </Empty>
  );
}
