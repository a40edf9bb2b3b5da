import { Button, Group, List, Modal, Stack, Text, TextInput } from "@mantine/core";
import { useState } from "react";
import { useNavigate } from "react-router";

import { useAddDevice, type Device } from "../../api/devices";
import { fetchFile } from "../../api/files";
import { fileAddress } from "../../api/robots";
import { ProblemBox } from "../../parts/ProblemBox";
import { useDeed } from "../../parts/useDeed";
import { writeDevice, type DeviceContent } from "./deviceFile";

type Props = {
  opened: boolean;
  close: () => void;
  device: Device;
  text: string;
  content: DeviceContent;
  changes: string[];
};

/** The changed device becomes the next version, checked on the robot as any other; its bench tests go along. */
export function SaveDevice({ opened, close, device, text, content, changes }: Props) {
  const [name, setName] = useState(content.name);
  const add = useAddDevice();
  const navigate = useNavigate();
  const { start, busy, error } = useDeed();
  const save = async () => {
    const files = new Map<string, Blob>();
    for (const file of device.files ?? []) {
      if (file.path !== "device.yaml") files.set(file.path, await fetchFile(fileAddress("devices", device.id, file.path)));
    }
    files.set("device.yaml", new Blob([writeDevice(text, { ...content, name: name.trim() || content.name })]));
    const made = await add.mutateAsync({ files, robot: device.robot_id });
    close();
    await navigate(`/devices/${made.id}`);
  };
  return (
    <Modal opened={opened} onClose={close} title="Save as a new version" centered closeButtonProps={{ "aria-label": "Close" }}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          start(save);
        }}
      >
        <Stack>
          <List size="sm">
            {changes.map((change) => (
              <List.Item key={change}>{change}</List.Item>
            ))}
          </List>
          <TextInput
            data-autofocus
            label="Name"
            description="The same name makes its next version, another one a device of its own."
            value={name}
            onChange={(event) => setName(event.currentTarget.value)}
            required
            maxLength={200}
          />
          <Text size="sm" c="dimmed">
            The version that is there stays as it is.
          </Text>
          {error !== null && <ProblemBox error={error} />}
          <Group justify="flex-end">
            <Button variant="default" onClick={close}>
              Not now
            </Button>
            <Button type="submit" loading={busy}>
              Save
            </Button>
          </Group>
        </Stack>
      </form>
    </Modal>
  );
}
