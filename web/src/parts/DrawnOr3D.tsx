import { Paper, SegmentedControl, Stack } from "@mantine/core";
import { Suspense, useState, type ReactNode } from "react";

import { Loading } from "./Loading";

/** A drawing, or the same in 3D, which is loaded when it is asked for. */
export function DrawnOr3D({ drawing, solid }: { drawing: ReactNode; solid: () => ReactNode }) {
  const [shown, show] = useState("drawing");
  return (
    <Paper withBorder p="sm">
      <Stack gap="xs">
        <SegmentedControl
          aria-label="How it is shown"
          value={shown}
          onChange={show}
          data={[
            { value: "drawing", label: "Drawing" },
            { value: "3d", label: "3D" },
          ]}
        />
        {shown === "3d" ? <Suspense fallback={<Loading what="the 3D view" />}>{solid()}</Suspense> : drawing}
      </Stack>
    </Paper>
  );
}
