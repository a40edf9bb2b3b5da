import { Paper, Stack, Title } from "@mantine/core";
import type { ReactNode } from "react";

/** In place of a list that holds nothing: why, and what to do. */
export function Empty({ title, heading = 2, children }: { title: string; heading?: 1 | 2 | 3; children: ReactNode }) {
  return (
    <Paper withBorder p="xl">
      {heading === 1 && <title>{`${title} · exogauge`}</title>}
      <Stack gap="sm" align="flex-start">
        <Title order={heading} size="h3">
          {title}
        </Title>
        {children}
      </Stack>
    </Paper>
  );
}
