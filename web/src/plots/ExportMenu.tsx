import { Button, Menu, useComputedColorScheme } from "@mantine/core";
import { IconDownload } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";

import { address } from "../app/base";
import { needed, type Panel } from "./channels";
import { drawing } from "./drawing";
import { savePng, saveSvg } from "./picture";
import type { Window } from "./Plot";
import { drawable } from "./polyline";
import type { Source, Tiles } from "./series";

type Props = { source: Source; log: string; panels: Panel[]; hidden: readonly string[]; doubts: boolean; window: Window };

/** What is on show, as a file: every sample from the service, or the picture as it is. */
export function ExportMenu({ source, log, panels, hidden, doubts, window }: Props) {
  const cache = useQueryClient();
  const scheme = useComputedColorScheme("light");
  const shown = panels.map((panel) => ({ panel, lines: panel.lines.filter((line) => !hidden.includes(line.channel)) }));
  const name = `${log}_${window.from.toFixed(2)}-${window.to.toFixed(2)}s`;

  const picture = () => {
    const pictured = shown.map(({ panel, lines }) => {
      const asked = ["tiles", source.id, log, needed(panel.lines), window.from, window.to];
      const found = cache.getQueriesData<Tiles>({ queryKey: asked }).find(([, tiles]) => tiles)?.[1];
      return { panel, lines, drawn: drawable(found, lines, doubts, panel.scale) };
    });
    return drawing(`${log}, ${window.from.toFixed(3)} … ${window.to.toFixed(3)} s`, pictured, window, scheme);
  };

  return (
    <Menu position="bottom-end" withinPortal>
      <Menu.Target>
        <Button variant="default" size="xs" leftSection={<IconDownload size={16} aria-hidden />} disabled={!panels.length}>
          Export this window
        </Button>
      </Menu.Target>
      <Menu.Dropdown>
        <Menu.Label>Every sample of what is shown</Menu.Label>
        <Menu.Item component="a" href={rows(source, log, shown, window, "csv")} download>
          CSV
        </Menu.Item>
        <Menu.Item component="a" href={rows(source, log, shown, window, "parquet")} download>
          Parquet
        </Menu.Item>
        <Menu.Label>The picture</Menu.Label>
        <Menu.Item onClick={() => saveSvg(name, picture().svg)}>SVG</Menu.Item>
        <Menu.Item
          onClick={() => {
            const { svg, width, height } = picture();
            void savePng(name, svg, width, height);
          }}
        >
          PNG
        </Menu.Item>
      </Menu.Dropdown>
    </Menu>
  );
}

function rows({ of, id }: Source, log: string, shown: { lines: Panel["lines"] }[], window: Window, format: string): string {
  const asked = new URLSearchParams({ start: String(window.from), end: String(window.to), format });
  for (const channel of shown.flatMap(({ lines }) => needed(lines))) asked.append("channels", channel);
  const series = of === "motions" ? "series" : `series/${encodeURIComponent(log)}`;
  return address(`api/v1/${of}/${id}/${series}/window?${asked}`);
}
