import type { Role } from "../../api/session";

export const ROLES: { value: Role; label: string }[] = [
  { value: "viewer", label: "viewer: reads" },
  { value: "member", label: "member: hands in, runs, deletes" },
  { value: "admin", label: "admin: invites, too" },
];
