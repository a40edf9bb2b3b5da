import { keepPreviousData, useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas } from "./client";

export type WhatIf = Schemas["WhatIfOut"];
export type Change = Schemas["WhatIfRequest"]["changes"] extends (infer One)[] | undefined ? One : never;

/** What a changed device would do over a log of a study; the last answer stays until the next is there. */
export function useWhatIf(studyId: string | undefined, log: string | undefined, changes: Change[]) {
  return useQuery({
    queryKey: ["what-if", studyId, log, changes],
    enabled: studyId !== undefined && log !== undefined,
    placeholderData: keepPreviousData,
    staleTime: 60_000,
    gcTime: 30_000,
    retry: false,
    queryFn: ({ signal }) =>
      answer(
        api.POST("/api/v1/studies/{study_id}/whatif", {
          params: { path: { study_id: studyId ?? "" } },
          body: { log: log ?? "", changes, series: true, main: [] },
          signal,
        }),
      ),
  });
}
