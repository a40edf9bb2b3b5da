import { Button, CopyButton, Stack, Text } from "@mantine/core";
import { IconLink, IconPrinter } from "@tabler/icons-react";

import { useComparison } from "../../api/compare";
import { Empty } from "../../parts/Empty";
import { LinkButton } from "../../parts/LinkButton";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { usePrintInLight } from "../../parts/usePrintInLight";
import { ProblemBox } from "../../parts/ProblemBox";
import { DifferingSettings } from "./DifferingSettings";
import { Exports } from "./Exports";
import { IdentificationMatrix } from "./IdentificationMatrix";
import { JobPicker } from "./JobPicker";
import { JobRecord } from "./JobRecord";
import { Overlay } from "./Overlay";
import { useSelection } from "./selection";
import { StiffnessMatrix } from "./StiffnessMatrix";
import { SupportMatrix } from "./SupportMatrix";
import styles from "./ComparePage.module.css";

export function Component() {
  const [selection, select] = useSelection();
  const { data: comparison, error, refetch, isFetching } = useComparison(selection.jobs);
  const some = selection.jobs.length > 0;
  usePrintInLight();
  return (
    <div className={styles.page}>
      <PageTitle title="Compare" lead="Devices, motions and approaches side by side; every number is that of its job’s results.json.">
        <LinkButton variant="default" to="/compare/labs">
          One device in several labs
        </LinkButton>
        {some && (
          <>
            <CopyButton value={window.location.href}>
              {({ copied, copy }) => (
                <Button variant="default" leftSection={<IconLink size={16} aria-hidden />} onClick={copy} className={styles.control}>
                  {copied ? "Copied" : "Copy the link"}
                </Button>
              )}
            </CopyButton>
            <Button variant="default" leftSection={<IconPrinter size={16} aria-hidden />} onClick={() => window.print()} className={styles.control}>
              Print or PDF
            </Button>
          </>
        )}
      </PageTitle>
      <Stack gap="xl">
        <JobPicker chosen={selection.jobs} choose={(jobs) => select({ jobs })} />
        {error && !isFetching && <ProblemBox error={error} retry={() => void refetch()} />}
        {!some ? (
          <Empty title="Nothing is chosen yet">
            <Text>Choose one or more evaluations above: one shows its devices and approaches, several stand side by side.</Text>
          </Empty>
        ) : comparison && !error ? (
          <>
            <Exports jobs={selection.jobs} />
            <SupportMatrix comparison={comparison} selection={selection} select={select} />
            <Overlay comparison={comparison} selection={selection} select={select} />
            <StiffnessMatrix comparison={comparison} differing={selection.differing} />
            <IdentificationMatrix comparison={comparison} />
            <DifferingSettings comparison={comparison} />
            <JobRecord comparison={comparison} />
          </>
        ) : (
          !error && <Loading what="the comparison" lines={6} />
        )}
      </Stack>
    </div>
  );
}
