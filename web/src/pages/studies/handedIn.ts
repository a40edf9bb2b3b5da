/** What can be handed in as a folder with logs: a study, or a payload. */

import { answer, api, type Schemas } from "../../api/client";

export type Uploaded = Schemas["StudyFromUpload"];

type Kept = { id: string; latest_job?: unknown };

/** main: the file that must be there. list: its pages, and the key of what is asked of it. job: what is asked for once it is kept, or null. */
export type HandedIn = {
  main: string;
  list: "studies" | "payloads";
  keep: (body: Uploaded, signal: AbortSignal) => Promise<Kept>;
  job: (kept: Kept) => Schemas["JobRequest"] | null;
};

export const STUDY: HandedIn = {
  main: "study.yaml",
  list: "studies",
  keep: (body, signal) => answer(api.POST("/api/v1/studies/from-upload", { body, signal })),
  job: ({ id }) => ({ study_id: id, kind: "evaluate", settings: {} }),
};
