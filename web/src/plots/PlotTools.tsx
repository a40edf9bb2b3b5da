import { ActionIcon, Button, Group, Text, Tooltip } from "@mantine/core";
import { IconArrowLeft, IconArrowRight, IconArrowsHorizontal, IconZoomIn, IconZoomOut } from "@tabler/icons-react";
import type { ReactNode } from "react";

import type { Cursor } from "./cursor";
import type { Window } from "./Plot";
import { isWhole, panned, zoomed } from "./steps";

type Props = { window: Window; whole: Window; cursor: Cursor; onWindow: (window: Window) => void; children?: ReactNode };

/** Buttons for what keys and the pointer do, too. */
export function PlotTools({ window, whole, cursor, onWindow, children }: Props) {
  const all = isWhole(window, whole);
  const tools = [
    ["Zoom in", IconZoomIn, () => zoomed(window, whole, 0.5, cursor.time), false],
    ["Zoom out", IconZoomOut, () => zoomed(window, whole, 2, cursor.time), all],
    ["Earlier", IconArrowLeft, () => panned(window, whole, -0.5), window.from <= whole.from],
    ["Later", IconArrowRight, () => panned(window, whole, 0.5), window.to >= whole.to],
  ] as const;
  return (
    <Group gap="xs">
      <Group gap={4} role="group" aria-label="Window of time">
        {tools.map(([name, Icon, made, idle]) => (
          <Tooltip key={name} label={name} events={{ hover: true, focus: true, touch: false }}>
            <ActionIcon variant="default" size="md" aria-label={name} disabled={idle} onClick={() => onWindow(made())}>
              <Icon size={16} aria-hidden />
            </ActionIcon>
          </Tooltip>
        ))}
        <Button
          variant="default"
          size="xs"
          leftSection={<IconArrowsHorizontal size={16} aria-hidden />}
          disabled={all}
          onClick={() => onWindow(whole)}
        >
          Whole time
        </Button>
      </Group>
      <Text size="sm" c="dimmed" aria-live="polite" data-testid="window">
        {window.from.toFixed(3)} … {window.to.toFixed(3)} s
      </Text>
      {children}
    </Group>
  );
}
