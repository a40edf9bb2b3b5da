import { Button, Paper, Title } from "@mantine/core";
import { IconCube3dSphere } from "@tabler/icons-react";
import { lazy, Suspense, useState } from "react";

import { usePlans, type Payload } from "../../api/payloads";
import { Loading } from "../../parts/Loading";

const PayloadView = lazy(() => import("../../view3d/PayloadView"));

/** The payload on its robot, where it is asked for; drawn anew when something more was identified or planned. */
export function In3D({ payload }: { payload: Payload }) {
  const [shown, show] = useState(false);
  const { data: plans = [] } = usePlans(payload.id);
  const planned = plans.find(({ job, found }) => found?.kind === "postures" && job.state === "succeeded");
  const identified = payload.latest_job?.state === "succeeded" ? payload.latest_job.id : "";
  return (
    <section aria-labelledby="in-3d">
      <Title order={2} size="h3" id="in-3d" mb="xs">
        In 3D
      </Title>
      {shown ? (
        <Paper withBorder p="sm">
          <Suspense fallback={<Loading what="the 3D view" />}>
            <PayloadView payloadId={payload.id} name={payload.name} about={`${identified} ${planned?.job.id ?? ""}`} />
          </Suspense>
        </Paper>
      ) : (
        <Button variant="default" leftSection={<IconCube3dSphere size={16} aria-hidden />} onClick={() => show(true)}>
          Show it on its robot
        </Button>
      )}
    </section>
  );
}
