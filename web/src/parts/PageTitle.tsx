import { Group, Text, Title } from "@mantine/core";
import type { ReactNode } from "react";

/** The heading of a page, which names the browser's tab too; children stand at its right. */
export function PageTitle({ title, lead, children }: { title: string; lead?: ReactNode; children?: ReactNode }) {
  return (
    <>
      <title>{`${title} · exogauge`}</title>
      <Group justify="space-between" align="flex-start" mb="md">
        <div>
          <Title order={1}>{title}</Title>
          {lead && <Text c="dimmed">{lead}</Text>}
        </div>
        {children && <Group gap="xs">{children}</Group>}
      </Group>
    </>
  );
}
