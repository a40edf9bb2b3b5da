import { Button, Menu, Text } from "@mantine/core";
import { IconUser } from "@tabler/icons-react";
import { Link } from "react-router";

import { showLab, signOut, useArrive, useSession } from "../api/session";
import { useDeed } from "../parts/useDeed";

/** Who is signed in, and in which lab. Nothing where there are no accounts. */
export function AccountMenu() {
  const { data: session } = useSession();
  const arrive = useArrive();
  const { start } = useDeed();
  if (!session?.account) return null;
  const { account, lab, labs = [] } = session;
  const look = (id: string) =>
    start(async () => {
      await showLab(id);
      await arrive("/studies");
    });
  return (
    <Menu position="bottom-end">
      <Menu.Target>
        <Button variant="default" leftSection={<IconUser size={16} aria-hidden />} aria-label={`Account of ${account.name}, lab ${lab?.name ?? "none"}`}>
          {lab?.name ?? account.name}
        </Button>
      </Menu.Target>
      <Menu.Dropdown>
        <Menu.Label>
          {account.name}
          <Text size="xs">{account.email}</Text>
        </Menu.Label>
        <Menu.Item component={Link} to="/account">
          Account and tokens
        </Menu.Item>
        {lab && (
          <Menu.Item component={Link} to="/lab">
            Lab {lab.name}
          </Menu.Item>
        )}
        {labs.length > 1 && (
          <>
            <Menu.Divider />
            <Menu.Label>Show another lab</Menu.Label>
            {labs
              .filter((each) => each.id !== lab?.id)
              .map((each) => (
                <Menu.Item key={each.id} onClick={() => look(each.id)}>
                  {each.name}
                </Menu.Item>
              ))}
          </>
        )}
        <Menu.Divider />
        <Menu.Item onClick={() => start(async () => { await signOut(); await arrive("/sign-in"); })}>Sign out</Menu.Item>
      </Menu.Dropdown>
    </Menu>
  );
}
