/** One hand-in from the choice of files to the page of what they are. */

import { useQueryClient } from "@tanstack/react-query";
import { useEffect, useRef, useState } from "react";
import { useNavigate } from "react-router";

import { limits } from "../../api/limits";
import { onceSignedIn } from "../../api/reachable";
import type { Problem } from "../../api/refusal";
import { useSubmitJob } from "../../api/studies";
import { useKeep } from "../../app/kept";
import type { HandedIn } from "./handedIn";
import { refusedBeforehand, type Picked } from "./picked";
import { send, type Progress } from "./send";

type State =
  | { step: "idle" }
  | { step: "sending"; files: Picked[]; progress: Progress }
  | { step: "refused"; error?: unknown; problem?: Problem };

/** What was on its way when somebody had to sign in. */
export type Broken = { path: string; files: number };

export function useHandIn(of: HandedIn, evaluate: boolean) {
  const [state, setState] = useState<State>({ step: "idle" });
  const [broken, setBroken] = useState<Broken | null>(null);
  const onItsWay = state.step === "sending" ? { path: state.files[0]?.path ?? "", files: state.files.length } : null;
  useKeep("sending", onItsWay, setBroken);
  const sending = useRef<AbortController | null>(null);
  const navigate = useNavigate();
  const cache = useQueryClient();
  const submit = useSubmitJob();

  useEffect(() => () => sending.current?.abort(), []);

  async function handIn(files: Picked[]): Promise<void> {
    const problem = refusedBeforehand(files, limits, of.main);
    if (problem) return setState({ step: "refused", problem });
    const stopper = new AbortController();
    sending.current = stopper;
    const tell = (progress: Progress) => setState({ step: "sending", files, progress });
    tell({ sent: files.map(() => 0), reading: false });
    try {
      const kept = await send(files, tell, stopper.signal, of.keep);
      const wanted = evaluate && !kept.latest_job ? of.job(kept) : null;
      if (wanted) await onceSignedIn(() => submit.mutateAsync(wanted), stopper.signal);
      void cache.invalidateQueries({ queryKey: [of.list] });
      sending.current = null;
      await navigate(`/${of.list}/${kept.id}`);
    } catch (error) {
      if (stopper.signal.aborted) setState({ step: "idle" });
      else setState({ step: "refused", error });
    }
  }

  return { state, broken, handIn, stop: () => sending.current?.abort() };
}
