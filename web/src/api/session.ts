import { useQuery, useQueryClient } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import { answer, api, type Schemas } from "./client";

export type Session = Schemas["SessionOut"];
export type Role = Schemas["LabOut"]["role"];

/** Who is signed in, in which lab. Asked once; what changes it asks again. */
export function useSession() {
  return useQuery({
    queryKey: ["session"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/session", { signal })),
    staleTime: Infinity,
    retry: false,
  });
}

/** Forgets all that was shown to whoever was there before, and goes on at `to`. */
export function useArrive() {
  const cache = useQueryClient();
  const navigate = useNavigate();
  return async (to: string) => {
    cache.clear();
    await cache.fetchQuery({ queryKey: ["session"], queryFn: () => answer(api.GET("/api/v1/session")) });
    await navigate(to, { replace: true });
  };
}

/** The path to go back to, if it is one of ours. */
export function ownPath(text: string | null): string {
  return text?.startsWith("/") && !text.startsWith("//") && !text.includes("\\") ? text : "/studies";
}

export const signIn = (body: Schemas["SignIn"]) => answer<unknown>(api.POST("/api/v1/session", { body }));
export const signOut = () => answer<unknown>(api.DELETE("/api/v1/session"));
export const signOutElsewhere = () => answer<unknown>(api.DELETE("/api/v1/sessions"));
export const setUp = (body: Schemas["SetUp"]) => answer<unknown>(api.POST("/api/v1/set-up", { body }));
export const showLab = (lab_id: string) => answer<unknown>(api.PUT("/api/v1/session/lab", { body: { lab_id } }));
export const changePassword = (body: Schemas["NewPassword"]) => answer<unknown>(api.PUT("/api/v1/account/password", { body }));
export const closeLab = (name: string) => answer<unknown>(api.DELETE("/api/v1/lab", { params: { query: { name } } }));
export const createLab = (name: string) => answer(api.POST("/api/v1/labs", { body: { name } }));
export const lookAtInvitation = (code: string) => answer(api.POST("/api/v1/invitations/look", { body: { code } }));
export const acceptInvitation = (body: Schemas["Accept"]) => answer<unknown>(api.POST("/api/v1/invitations/accept", { body }));
