import { Anchor, Button, Group, Text } from "@mantine/core";
import { useNavigate } from "react-router";

import { answer, api } from "../../api/client";
import { useAddDevice, type Device } from "../../api/devices";
import { fetchFile } from "../../api/files";
import { fileAddress } from "../../api/robots";
import { address } from "../../app/base";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";
import { readDevice } from "../device/deviceFile";

/** What was named of a device's bands becomes the next version of that device; or a file, where none is kept. */
export function TakeOver({ file, jobId }: { file: string; jobId: string }) {
  const add = useAddDevice();
  const navigate = useNavigate();
  const { start, busy, error } = useDeed();
  const href = address(`api/v1/jobs/${jobId}/artifacts/${file}`);
  const save = async () => {
    const text = await (await fetchFile(href)).text();
    const { name } = readDevice(text);
    const page = await answer(api.GET("/api/v1/devices", { params: { query: { limit: 1, name } } }));
    const latest = page.items[0] as Device | undefined;
    if (!latest) throw new Error(`No device named “${name}” is kept here. Download the file and hand it in with its robot.`);
    const device = await answer(api.GET("/api/v1/devices/{device_id}", { params: { path: { device_id: latest.id } } }));
    const files = new Map<string, Blob>();
    for (const kept of device.files ?? []) {
      if (kept.path !== "device.yaml") files.set(kept.path, await fetchFile(fileAddress("devices", device.id, kept.path)));
    }
    files.set("device.yaml", new Blob([text]));
    const made = await add.mutateAsync({ files, robot: device.robot_id });
    await navigate(`/devices/${made.id}`);
  };
  return (
    <div>
      <Group gap="sm">
        <ForMembers>
          <Button variant="default" loading={busy} onClick={() => start(save)}>
            Take over into the device
          </Button>
        </ForMembers>
        <Anchor size="sm" href={href} download>
          {file}
        </Anchor>
      </Group>
      <Text size="sm" c="dimmed" mt={4}>
        A new version of the device states what was named of its bands. What-if can ask it, and evaluated with it these logs leave nothing of that.
      </Text>
      {error !== null && <ProblemBox error={error} />}
    </div>
  );
}
