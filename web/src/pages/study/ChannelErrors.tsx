import { Button, SegmentedControl, Stack, Text, Title } from "@mantine/core";
import { useMemo, useState } from "react";

import { isNumber } from "../../parts/digits";
import { BeforeAfter, type ErrorRow } from "./BeforeAfter";
import type { Fit } from "./results";

const FIRST = 10;
const KINDS = { all: "All", tau: "Joint torque", base: "Base", ft: "Sensors" } as const;

/** samples: how long each log is, its weight where errors are pooled. steadyWords: what the error in steady motion says. */
type Props = { fits: Fit[]; heldOut: boolean; samples: ReadonlyMap<string, number>; steadyWords: string | undefined };

/** Error per channel, the furthest above its noise first. */
export function ChannelErrors({ fits, heldOut, samples, steadyWords }: Props) {
  const [kind, setKind] = useState<keyof typeof KINDS>("all");
  const [all, setAll] = useState(false);
  const rows = useMemo(() => pooled(fits.filter((fit) => fit.held_out === heldOut), samples), [fits, heldOut, samples]);
  const kinds = Object.entries(KINDS).filter(([value]) => value === "all" || rows.some(({ channel }) => channel.startsWith(`${value}.`)));
  const wanted = rows.filter(({ channel }) => kind === "all" || channel.startsWith(`${kind}.`));
  return (
    <section aria-labelledby="channels">
      <Title order={2} size="h3" id="channels">
        Channel by channel
      </Title>
      <Text size="sm" c="dimmed" mb="sm">
        Root mean square over the {heldOut ? "held-out" : "fitted"} logs; the furthest above its noise floor first.
      </Text>
      {steadyWords && rows.some(({ steady }) => isNumber(steady)) && (
        <Text size="sm" c="dimmed" mb="sm">
          {steadyWords}
        </Text>
      )}
      <Stack gap="sm" align="flex-start">
        <SegmentedControl
          size="xs"
          aria-label="Channels"
          data={kinds.map(([value, label]) => ({ value, label }))}
          value={kind}
          onChange={(value) => setKind(value as keyof typeof KINDS)}
        />
        <div style={{ width: "100%" }}>
          <BeforeAfter name="Error of each channel" rows={all ? wanted : wanted.slice(0, FIRST)} />
        </div>
        {wanted.length > FIRST && (
          <Button variant="default" size="xs" onClick={() => setAll(!all)}>
            {all ? `Only the first ${FIRST}` : `All ${wanted.length} channels`}
          </Button>
        )}
      </Stack>
    </section>
  );
}

/** Over all samples of the logs, as results.json pools its summary. */
function pooled(fits: Fit[], samples: ReadonlyMap<string, number>): (ErrorRow & { channel: string })[] {
  const channels = new Map<string, Fit[]>();
  for (const fit of fits) channels.set(fit.channel, [...(channels.get(fit.channel) ?? []), fit]);
  const rms = (found: Fit[], key: "rmse_prior" | "rmse_identified" | "rmse_moving" | "noise_floor") => {
    const known = found.filter((fit) => isNumber(fit[key])).map((fit) => [samples.get(fit.log) ?? 1, fit[key] as number]);
    const total = known.reduce((sum, [weight]) => sum + weight!, 0);
    return total > 0 ? Math.sqrt(known.reduce((sum, [weight, value]) => sum + weight! * value! ** 2, 0) / total) : null;
  };
  const rows = [...channels].map(([channel, found]) => ({
    channel,
    name: found[0]!.channel_words ?? channel,
    before: rms(found, "rmse_prior"),
    after: rms(found, "rmse_identified"),
    steady: channel.startsWith("tau.") ? rms(found, "rmse_moving") : null, // what has no friction is steady throughout
    floor: rms(found, "noise_floor"),
    unit: found[0]!.unit,
    sort: channel.startsWith("ft.") ? "sensor" : "", // its moments would drown among joint torques
  }));
  return rows.sort((one, two) => above(two) - above(one));
}

function above({ after, floor }: ErrorRow): number {
  return isNumber(after) && isNumber(floor) && floor > 0 ? after / floor : 0;
}
