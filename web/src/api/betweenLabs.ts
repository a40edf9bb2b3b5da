import { useQuery } from "@tanstack/react-query";

import { answer, api, type Schemas, whole } from "./client";

export type ComparedDevice = Schemas["ComparedDevice"];
export type Quantity = Schemas["QuantityOut"];
export type WornIn = Schemas["WornIn"];

/** Devices in all studies that one may see, of most labs first. */
export function useComparedDevices() {
  return useQuery({
    queryKey: ["compare", "devices"],
    queryFn: ({ signal }) => whole((query) => answer(api.GET("/api/v1/compare/devices", { params: { query }, signal }))),
  });
}

export function useComparedDevice(model: string, size: string | null) {
  return useQuery({
    queryKey: ["compare", "device", model, size],
    enabled: model !== "",
    queryFn: ({ signal }) => answer(api.GET("/api/v1/compare/device", { params: { query: { model, size: size ?? undefined } }, signal })),
  });
}
