import { Anchor, List, SegmentedControl, Stack, Text, Title } from "@mantine/core";
import { useState } from "react";
import { Link, useSearchParams } from "react-router";

import type { Study } from "../../api/studies";
import { percent, significant } from "../../parts/digits";
import type { Results, Support } from "./results";
import { Skipped } from "./Skipped";
import { DoubtTable, type Doubted } from "./DoubtTable";
import { PhaseTable } from "./PhaseTable";
import { SupportBars } from "./SupportBars";
import { SupportTable } from "./SupportTable";

type Props = { study: Study; results: Results };

/** The torque that the wear gives, motion by motion, joint by joint, by each approach. */
export function SupportSection({ study, results }: Props) {
  const [all, setAll] = useState("main");
  const [search] = useSearchParams();
  const found = results.support;
  if (!found.length)
    return <Skipped results={results} step="support" advice="It needs a device and a log recorded with it on (role with_device)." />;
  const motions = [...new Set(found.map((each) => each.motion))];
  return (
    <Stack gap="xl">
      <div>
        <Title order={2} size="h3">
          Supporting torque
        </Title>
        <List size="sm" spacing={2} mt={4}>
          <List.Item>
            <strong>A</strong>: torque without minus torque with the device, on the same motion
          </List.Item>
          <List.Item>
            <strong>B</strong>: what the identified model needs minus what was measured
          </List.Item>
          <List.Item>
            <strong>Paired</strong>: B with the device minus B of its partner without it, at the same posture
          </List.Item>
          <List.Item>
            <strong>B, maker’s values</strong>: the same as B before identification
          </List.Item>
          <List.Item>
            <strong>Band model</strong>: what the bands give by {found[0]!.band_model ?? "the device file"}
          </List.Item>
        </List>
        <Text size="sm" c="dimmed" mt={4}>
          RMSE is against the band model, over all samples. By the maker’s values and of the band model ± is the scatter of the trials
          alone. {results.reading?.support_table ?? "± is one standard deviation."}
        </Text>
      </div>
      <SegmentedControl
        size="xs"
        style={{ alignSelf: "flex-start" }}
        aria-label="Joints"
        data={[
          { value: "main", label: "Joints that the wear acts on most" },
          { value: "all", label: "All joints" },
        ]}
        value={all}
        onChange={setAll}
      />
      {motions.map((motion) => {
        const here = found.filter((each) => each.motion === motion);
        const rows = all === "all" ? here : here.filter((each) => each.main);
        return (
          <section key={motion} aria-labelledby={`motion-${motion}`}>
            <Title order={3} size="h4" id={`motion-${motion}`}>
              Motion {motion}
            </Title>
            <Text size="sm" mb="xs">
              {equalityWords(here)}
            </Text>
            <SupportBars motion={motion} rows={rows} />
            <SupportTable motion={motion} rows={rows} />
            <PhaseTable motion={motion} rows={rows} />
            <DoubtTable
              summary={`What the doubts of peak and mean are made of, motion ${motion}`}
              numbers={rows.flatMap(doubtsOf)}
              sources={results.doubt_sources ?? []}
            />
            <Text size="sm" mt={6}>
              Over time:{" "}
              {logsOf(here).map((log, k) => (
                <span key={log}>
                  {k > 0 && ", "}
                  <Anchor component={Link} to={{ pathname: `/studies/${study.id}/plots`, search: plotsOf(search, log, rows) }}>
                    {log}
                  </Anchor>
                </span>
              ))}
            </Text>
          </section>
        );
      })}
    </Stack>
  );
}

/** Of the headline's peak and mean. */
function doubtsOf({ joint, device, peak, mean }: Support, _k: number, all: Support[]): Doubted[] {
  const whose = new Set(all.map((each) => each.device)).size > 1 ? `, ${device}` : "";
  return Object.entries({ peak, mean }).map(([name, found]) => ({
    name: `${joint}, ${name}${whose}`,
    unit: found?.unit ?? "",
    parts: found?.budget ?? [],
  }));
}

/** The gate of approach A: whether the compared motions are the same. */
function equalityWords(rows: Support[]): string {
  const compared = rows.map((each) => each.motion_equality).filter((each) => each !== null);
  if (!compared.length) return "There is no run without the device of this motion: approach A is not possible.";
  const order = ["equal", "doubtful", "different"];
  const worst = compared.reduce((one, two) => (order.indexOf(two.verdict) > order.indexOf(one.verdict) ? two : one));
  const most = Math.max(...compared.map((each) => each.dq_share ?? 0));
  const words = `differ by ${most < 0.001 ? "less than 0.1 %" : `at most ${percent(most, 1)}`} of a joint’s own velocity (rms) and ${significant(
    Math.max(...compared.map((each) => each.q_rms ?? 0)) * 1000,
    2,
  )} mrad`;
  if (worst.verdict === "equal") return `The motions with and without the device are equal: they ${words}.`;
  return `The motions with and without the device are ${worst.verdict}: they ${words}. Approach A bears that difference.`;
}

/** The first log of each device. */
function logsOf(rows: Support[]): string[] {
  return [...new Map(rows.map((each) => [each.device, each.logs[0]])).values()].filter((log) => log !== undefined);
}

function plotsOf(search: URLSearchParams, log: string, rows: Support[]): string {
  const next = new URLSearchParams();
  const job = search.get("job");
  if (job) next.set("job", job);
  next.set("log", log);
  for (const joint of new Set(rows.filter((each) => each.main).map((each) => each.joint))) next.append("show", `support.${joint}`);
  next.append("show", "tension");
  return next.toString();
}
