import { Button, Group, Stack } from "@mantine/core";
import { useCallback, useEffect, useRef, useState } from "react";
import { useSearchParams } from "react-router";

import { Loading } from "../../../parts/Loading";
import { PageTitle } from "../../../parts/PageTitle";
import { ForMembers } from "../../../parts/ForMembers";
import { ProblemBox } from "../../../parts/ProblemBox";
import { isOpen, placed, STEPS, stepOf, type Step } from "./faults";
import { RecordStep } from "./RecordStep";
import { ResultStep } from "./ResultStep";
import { SensorStep } from "./SensorStep";
import styles from "./Steps.module.css";
import { StepFaults } from "./StepFaults";
import { useDraft } from "./useDraft";
import { WorkspaceStep } from "./WorkspaceStep";

const TITLES: Record<Step, string> = {
  sensor: "Sensor",
  workspace: "Workspace",
  postures: "Postures",
  excitation: "Excitation",
  result: "Result",
};

/** A payload from a lab's own files, step by step. The address says which step; the draft stays in the tab. */
export function Component() {
  return (
    <ForMembers told>
      <Steps />
    </ForMembers>
  );
}

function Steps() {
  const [search, setSearch] = useSearchParams();
  const from = search.get("from");
  const step = STEPS.find((each) => each === search.get("step")) ?? "sensor";
  const drafted = useDraft(from, step === "result");
  const { draft, opening, failed, verdict, judging } = drafted;
  const [tried, setTried] = useState<Step[]>([]);
  const heading = useRef<HTMLHeadingElement>(null);
  const before = useRef(step);
  useEffect(() => {
    if (before.current === step) return;
    setTried((now) => [...new Set([...now, before.current])]);
    before.current = step;
    window.scrollTo(0, 0);
    heading.current?.focus();
  }, [step]);
  const go = (next: Step) => setSearch({ ...(draft.base && { from: draft.base }), step: next });
  const kept = useCallback((id: string) => setSearch({ from: id, step }, { replace: true, preventScrollReset: true }), [setSearch, step]);
  if (failed) return <ProblemBox error={failed} />;
  if (opening) return <Loading what="the payload" />;

  const all = (verdict?.errors ?? []).map(placed);
  const nothing = all.filter(({ code }) => code === "no_logs");
  const by = (each: Step) => all.filter((fault) => !nothing.includes(fault) && stepOf(fault, draft.content) === each);
  const ready = !judging && verdict !== undefined && verdict.errors.length === 0;
  const place = STEPS.indexOf(step);
  const props = { drafted, faults: by(step), tried: tried.includes(step) };
  return (
    <>
      <PageTitle title={draft.base ? `${draft.content.name ?? "Payload"}: change or add` : "New payload"} lead="From your own files, step by step. Nothing is lost on the way back.">
        <Button
          variant="default"
          onClick={() => {
            drafted.anew();
            setTried([]);
            setSearch({});
          }}
        >
          Start anew
        </Button>
      </PageTitle>
      <nav aria-label="Steps">
        <ol className={styles.steps}>
          {STEPS.map((each, k) => {
            const wrong = by(each).some((fault) => !isOpen(fault));
            const open = tried.includes(each) && by(each).length > 0;
            return (
              <li key={each}>
                <Button variant={each === step ? "filled" : "default"} size="sm" aria-current={each === step ? "step" : undefined} onClick={() => go(each)}>
                  {k + 1} {TITLES[each]}
                  {wrong ? " (does not fit)" : open ? " (open)" : ""}
                </Button>
              </li>
            );
          })}
        </ol>
      </nav>
      <Stack gap="lg" mt="md">
        <h2 ref={heading} tabIndex={-1} className={styles.heading}>
          {TITLES[step]}
        </h2>
        {step === "sensor" && <SensorStep {...props} />}
        {step === "workspace" && <WorkspaceStep {...props} />}
        {(step === "postures" || step === "excitation") && <RecordStep {...props} what={step} ready={ready} kept={kept} />}
        {step === "result" && <ResultStep {...props} ready={ready} kept={kept} />}
        <StepFaults faults={[...by(step), ...(step === "result" ? nothing : [])]} />
        {drafted.lookError && <ProblemBox error={drafted.lookError} />}
        {drafted.verdictError && <ProblemBox error={drafted.verdictError} />}
        <Group justify="space-between">
          {place > 0 ? (
            <Button variant="default" onClick={() => go(STEPS[place - 1]!)}>
              Back: {TITLES[STEPS[place - 1]!]}
            </Button>
          ) : (
            <span />
          )}
          {place < STEPS.length - 1 && <Button onClick={() => go(STEPS[place + 1]!)}>Next: {TITLES[STEPS[place + 1]!]}</Button>}
        </Group>
      </Stack>
    </>
  );
}
