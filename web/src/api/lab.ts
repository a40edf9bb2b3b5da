import { useInfiniteQuery, useQuery, useQueryClient } from "@tanstack/react-query";

import { answer, api, type Schemas, whole } from "./client";
import type { Role } from "./session";

export type Member = Schemas["MemberOut"];
export type Invitation = Schemas["InvitationOut"];
export type Token = Schemas["TokenOut"];
export type AuditEntry = Schemas["AuditOut"];

export type Retention = Schemas["Retention"];

const PAGE = 50;

export function useMembers() {
  return useQuery({
    queryKey: ["lab", "members"],
    queryFn: ({ signal }) => whole((query) => answer(api.GET("/api/v1/lab/members", { params: { query }, signal }))),
  });
}

export function useInvitations(enabled: boolean) {
  return useQuery({
    queryKey: ["lab", "invitations"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/lab/invitations", { params: { query: { limit: PAGE } }, signal })),
    enabled,
  });
}

export function useTokens() {
  return useQuery({
    queryKey: ["lab", "tokens"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/tokens", { params: { query: { limit: 200 } }, signal })),
  });
}

export function useAudit(search: string) {
  return useInfiniteQuery({
    queryKey: ["lab", "audit", search],
    queryFn: ({ pageParam, signal }) =>
      answer(api.GET("/api/v1/lab/audit", { params: { query: { limit: PAGE, cursor: pageParam, search: search || undefined } }, signal })),
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next_cursor ?? undefined,
  });
}

export function useRetention() {
  return useQuery({
    queryKey: ["lab", "retention"],
    queryFn: ({ signal }) => answer(api.GET("/api/v1/lab/retention", { signal })),
  });
}

/** What changes a lab; its lists are asked for again. */
export function useLabDeeds() {
  const cache = useQueryClient();
  const then = async <T>(asked: Promise<T>): Promise<T> => {
    const got = await asked;
    await cache.invalidateQueries({ queryKey: ["lab"] });
    return got;
  };
  return {
    setRole: (account_id: string, role: Role) =>
      then(answer(api.PUT("/api/v1/lab/members/{account_id}", { params: { path: { account_id } }, body: { role } }))),
    remove: (account_id: string) =>
      then(answer<unknown>(api.DELETE("/api/v1/lab/members/{account_id}", { params: { path: { account_id } } }))),
    invite: (email: string, role: Role) => then(answer(api.POST("/api/v1/lab/invitations", { body: { email, role } }))),
    withdraw: (invitation_id: string) =>
      then(answer<unknown>(api.DELETE("/api/v1/lab/invitations/{invitation_id}", { params: { path: { invitation_id } } }))),
    makeToken: (body: Schemas["NewToken"]) => then(answer(api.POST("/api/v1/tokens", { body }))),
    revokeToken: (token_id: string) => then(answer<unknown>(api.DELETE("/api/v1/tokens/{token_id}", { params: { path: { token_id } } }))),
  };
}
