import { lazy, Suspense, useEffect } from "react";
import { useLocation } from "react-router";

import type { Study } from "../../api/studies";
import { Loading } from "../../parts/Loading";
import { DisagreementSection } from "./DisagreementSection";
import { FilesSection } from "./FilesSection";
import { IdentificationSection } from "./IdentificationSection";
import type { Job } from "./jobs";
import { isEvaluation, type Answer } from "./results";
import { RunSection } from "./RunSection";
import { ScopeSection } from "./ScopeSection";
import type { SectionKey } from "./sections";
import { StiffnessSection } from "./StiffnessSection";
import { SummarySection } from "./SummarySection";
import { summaryOf } from "./summary";
import { SupportSection } from "./SupportSection";

const PlotsSection = lazy(() => import("./PlotsSection"));

type Props = { name: SectionKey; study: Study; job: Job; results?: Answer };

/** One part of the review. An address may end with a heading of it: `#parameters`. */
export function Section(props: Props) {
  const { hash } = useLocation();
  const { name, job } = props;
  useEffect(() => {
    if (hash) document.getElementById(decodeURIComponent(hash.slice(1)))?.scrollIntoView();
  }, [hash, name, job.id]);
  return <Part {...props} />;
}

function Part({ name, study, job, results }: Props) {
  if (name === "files") return <FilesSection job={job} />;
  if (name === "run" || !isEvaluation(results))
    return <RunSection study={study} job={job} results={isEvaluation(results) ? results : undefined} />;
  switch (name) {
    case "summary":
      return <SummarySection study={study} results={results} />;
    case "identification":
      return <IdentificationSection results={results} logs={summaryOf(study).logs ?? []} />;
    case "support":
      return <SupportSection study={study} results={results} />;
    case "stiffness":
      return <StiffnessSection results={results} />;
    case "disagreement":
      return <DisagreementSection study={study} job={job} results={results} />;
    case "scope":
      return <ScopeSection job={job} results={results} />;
    case "plots":
      return (
        <Suspense fallback={<Loading what="the plots" />}>
          <PlotsSection study={study} job={job} results={results} />
        </Suspense>
      );
  }
}
