/** What a study holds, as its checked summary says. */

import type { Study } from "../../api/studies";

export type StudyLog = {
  name: string;
  file: string[];
  role: string;
  motion: string | null;
  device: string | null;
  samples: number;
  rate_hz: number;
  duration_s: number;
};

export type StudySummary = {
  robot?: { name?: string; joints?: string[]; base?: string; mass_kg?: number };
  devices?: { name: string; file: string }[];
  logs?: StudyLog[];
  steps?: { step: string; skipped: string | null }[];
};

export function summaryOf(study: Study): StudySummary {
  return study.summary as StudySummary;
}

export const ROLES: Record<string, string> = {
  identification: "identification",
  validation: "held out",
  without_device: "without the device",
  with_device: "with the device",
};
