import { Anchor, Checkbox, Table, Text, Title } from "@mantine/core";
import { Link } from "react-router";

import { useFinishedJobs, type FinishedJob } from "../../api/compare";
import { useEveryStudy } from "../../api/studies";
import { factsOf } from "../studies/facts";
import { Empty } from "../../parts/Empty";
import { LinkButton } from "../../parts/LinkButton";
import { Loading } from "../../parts/Loading";
import { ProblemBox } from "../../parts/ProblemBox";
import { When } from "../../parts/When";
import { WideTable } from "../../parts/WideTable";
import styles from "./JobPicker.module.css";

const MOST = 20;
const KINDS: Record<string, string> = { evaluate: "every step", support: "supporting torque", stiffness: "bands" };

/** Finished evaluations; those chosen stand side by side. */
export function JobPicker({ chosen, choose }: { chosen: string[]; choose: (jobs: string[]) => void }) {
  const { data: jobs, error, refetch } = useFinishedJobs();
  const { studies } = useEveryStudy();
  if (error && !jobs) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!jobs) return <Loading what="the finished evaluations" />;
  if (jobs.length === 0) {
    return (
      <Empty title="No evaluation has finished yet">
        <Text>A study is compared once a job of it has succeeded.</Text>
        <LinkButton to="/studies">To the studies</LinkButton>
      </Empty>
    );
  }
  const known = new Map(studies.map((study) => [study.id, study]));
  const toggle = ({ id }: FinishedJob) => choose(chosen.includes(id) ? chosen.filter((each) => each !== id) : [...chosen, id]);
  return (
    <section aria-labelledby="jobs" className={styles.picker}>
      <Title order={2} size="h3" id="jobs" mb="sm">
        Finished evaluations
      </Title>
      <WideTable
        label="Finished evaluations"
        mostHeight="20rem"
        columns={["Study", "Robot and devices", "Evaluated", "When", "Code"]}
      >
        {jobs.map((job) => {
          const study = known.get(job.study_id ?? "");
          const name = study?.name ?? "An older study";
          return (
            <Table.Tr key={job.id}>
              <Table.Th scope="row">
                <Checkbox
                  label={name}
                  aria-label={`Compare ${name}, ${KINDS[job.kind] ?? job.kind}`}
                  checked={chosen.includes(job.id)}
                  disabled={!chosen.includes(job.id) && chosen.length >= MOST}
                  onChange={() => toggle(job)}
                />
              </Table.Th>
              <Table.Td>{study ? factsOf(study).join(" · ") : ""}</Table.Td>
              <Table.Td>
                <Anchor component={Link} to={`/studies/${job.study_id}`} size="sm">
                  {KINDS[job.kind] ?? job.kind}
                </Anchor>
              </Table.Td>
              <Table.Td>
                <When at={job.finished_at ?? job.created_at} />
              </Table.Td>
              <Table.Td>{job.code_version}</Table.Td>
            </Table.Tr>
          );
        })}
      </WideTable>
    </section>
  );
}
