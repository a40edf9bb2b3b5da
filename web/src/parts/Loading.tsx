import { Skeleton, Stack, VisuallyHidden } from "@mantine/core";

/** Grey lines where a list or a table will be. */
export function Loading({ what, lines = 4 }: { what: string; lines?: number }) {
  return (
    <Stack gap="sm" role="status">
      <VisuallyHidden>Loading {what} …</VisuallyHidden>
      {Array.from({ length: lines }, (_, k) => (
        <Skeleton key={k} height={56} />
      ))}
    </Stack>
  );
}
