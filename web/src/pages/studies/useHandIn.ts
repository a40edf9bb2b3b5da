/** One hand-in from the choice of files to the page of the study. */

import { useQueryClient } from "@tanstack/react-query";
import { useEffect, useRef, useState } from "react";
import { useNavigate } from "react-router";

import { limits } from "../../api/limits";
import type { Problem } from "../../api/refusal";
import { useSubmitJob } from "../../api/studies";
import { refusedBeforehand, type Picked } from "./picked";
import { send, type Progress } from "./send";

type State =
  | { step: "idle" }
  | { step: "sending"; files: Picked[]; progress: Progress }
  | { step: "refused"; error?: unknown; problem?: Problem };

export function useHandIn(evaluate: boolean) {
  const [state, setState] = useState<State>({ step: "idle" });
  const sending = useRef<AbortController | null>(null);
  const navigate = useNavigate();
  const cache = useQueryClient();
  const submit = useSubmitJob();

  useEffect(() => () => sending.current?.abort(), []);

  async function handIn(files: Picked[]): Promise<void> {
    const problem = refusedBeforehand(files, limits);
    if (problem) return setState({ step: "refused", problem });
    const stopper = new AbortController();
    sending.current = stopper;
    const tell = (progress: Progress) => setState({ step: "sending", files, progress });
    tell({ sent: files.map(() => 0), reading: false });
    try {
      const study = await send(files, tell, stopper.signal);
      if (evaluate && !study.latest_job) {
        await submit.mutateAsync({ study_id: study.id, kind: "evaluate", settings: {} });
      }
      void cache.invalidateQueries({ queryKey: ["studies"] });
      sending.current = null;
      await navigate(`/studies/${study.id}`);
    } catch (error) {
      if (stopper.signal.aborted) setState({ step: "idle" });
      else setState({ step: "refused", error });
    }
  }

  return { state, handIn, stop: () => sending.current?.abort() };
}
