import { Stack, Tabs } from "@mantine/core";
import { useNavigate, useParams } from "react-router";

import { useSession } from "../../api/session";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { NoLab } from "../account/AccountPage";
import { NoAccounts } from "../account/NoAccounts";
import { AuditLog } from "./AuditLog";
import { CloseLab } from "./CloseLab";
import { Invitations } from "./Invitations";
import { Members } from "./Members";
import { WhatGoes } from "./WhatGoes";
import { Webhooks } from "./Webhooks";

const TABS = ["audit", "age", "webhooks"];

export function Component() {
  const { data: session, error, refetch } = useSession();
  const navigate = useNavigate();
  const { "*": rest = "" } = useParams();
  if (error && !session) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!session) return <Loading what="the lab" />;
  if (!session.accounts) return <NoAccounts />;
  if (!session.lab) return <NoLab />;
  const admin = session.lab.role === "admin";
  return (
    <>
      <PageTitle title={session.lab.name} lead={`You are ${session.lab.role} of this lab.`} />
      {!admin ? (
        <Members admin={false} />
      ) : (
        <Tabs value={TABS.includes(rest) ? rest : "members"} onChange={(tab) => void navigate(TABS.includes(tab ?? "") ? `/lab/${tab}` : "/lab")}>
          <Tabs.List mb="md">
            <Tabs.Tab value="members">Members</Tabs.Tab>
            <Tabs.Tab value="audit">Audit</Tabs.Tab>
            <Tabs.Tab value="age">What goes by age</Tabs.Tab>
            <Tabs.Tab value="webhooks">Webhooks</Tabs.Tab>
          </Tabs.List>
          <Tabs.Panel value="members">
            <Stack gap="xl">
              <Members admin />
              <Invitations />
              <CloseLab name={session.lab.name} />
            </Stack>
          </Tabs.Panel>
          <Tabs.Panel value="audit">
            <AuditLog />
          </Tabs.Panel>
          <Tabs.Panel value="age">
            <WhatGoes />
          </Tabs.Panel>
          <Tabs.Panel value="webhooks">
            <Webhooks />
          </Tabs.Panel>
        </Tabs>
      )}
    </>
  );
}
