import { keepPreviousData, useMutation, useQuery, useQueryClient } from "@tanstack/react-query";

import { answer, api, type Schemas } from "./client";

export type Preview = Schemas["PreviewOut"];
export type Column = Schemas["ColumnOut"];
export type Finding = Schemas["FindingOut"];

/** What the file holds and, with a mapping, what becomes of it; the last answer stays until the next is there. */
export function usePreview(uploadId: string | undefined, robotId: string | undefined, mapping: object | string | undefined) {
  return useQuery({
    queryKey: ["import", uploadId, robotId, mapping],
    enabled: uploadId !== undefined,
    placeholderData: keepPreviousData,
    staleTime: Infinity,
    retry: false,
    queryFn: ({ signal }) =>
      answer(
        api.POST("/api/v1/imports/preview", {
          body: { upload_id: uploadId ?? "", robot_id: robotId, mapping: mapping as string | undefined },
          signal,
        }),
      ),
  });
}

/** The mapping, kept for the robot's next logs. */
export function useKeepMapping() {
  return useMutation({
    mutationFn: ({ robotId, mapping }: { robotId: string; mapping: object | string }) =>
      answer(
        api.PUT("/api/v1/robots/{robot_id}/mapping", {
          params: { path: { robot_id: robotId } },
          body: { mapping: mapping as string },
        }),
      ),
  });
}

export function useCreateLog() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: ({ uploadId, robotId, mapping }: { uploadId: string; robotId?: string; mapping?: object | string }) =>
      answer(
        api.POST("/api/v1/logs/from-upload", {
          body: { upload_id: uploadId, robot_id: robotId, mapping: mapping as string | undefined },
        }),
      ),
    onSuccess: () => cache.invalidateQueries({ queryKey: ["logs"] }),
  });
}

export type LogSummary = { channels?: string[]; samples?: number; rate_hz?: number; duration_s?: number };

export function useLogs() {
  return useQuery({
    queryKey: ["logs"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/logs", { params: { query: { limit: 100 } }, signal })),
  });
}

export function useCreateStudy() {
  const cache = useQueryClient();
  return useMutation({
    mutationFn: (parts: Schemas["StudyFromParts"]) => answer(api.POST("/api/v1/studies", { body: parts })),
    onSuccess: () => cache.invalidateQueries({ queryKey: ["studies"] }),
  });
}
