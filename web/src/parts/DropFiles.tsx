import { Button, FileButton, Group, Text, Title } from "@mantine/core";
import { Dropzone, type FileWithPath } from "@mantine/dropzone";
import { useId, type ReactNode } from "react";

import { ForMembers } from "./ForMembers";
import styles from "./DropFiles.module.css";
import { freePath } from "./freePath";

export type Dropped = Map<string, File>;

type Props = {
  title: string;
  choose: string;
  take: (files: Dropped) => void;
  busy?: boolean;
  single?: boolean;
  accept?: string;
  children: ReactNode;
};

/** Where files are dropped or chosen; with the paths that they have in a dropped folder. */
export function DropFiles({ title, choose, take, busy = false, single = false, accept, children }: Props) {
  const id = useId();
  const hand = (files: File[]) => files.length > 0 && take(withPaths(files));
  return (
    <ForMembers told>
    <section aria-labelledby={id}>
      <Dropzone
        onDrop={hand}
        multiple={!single}
        loading={busy}
        activateOnClick={false}
        activateOnKeyboard={false}
        tabIndex={-1}
        className={styles.zone}
        classNames={{ inner: styles.inner }}
      >
        <Title order={2} size="h4" id={id}>
          {title}
        </Title>
        <Text size="sm">{children}</Text>
        <Group gap="sm" mt="sm">
          <FileButton onChange={(chosen) => hand([chosen].flat().filter((file) => file !== null))} multiple={!single} accept={accept}>
            {(props) => (
              <Button {...props} loading={busy}>
                {choose}
              </Button>
            )}
          </FileButton>
        </Group>
      </Dropzone>
    </section>
    </ForMembers>
  );
}

/** Paths as they are below the one folder that was dropped. */
function withPaths(files: File[]): Dropped {
  const paths = files.map((file) => {
    const said = file.webkitRelativePath || (file as FileWithPath).path || file.name;
    return said.replace(/^(\.?\/)+/, "");
  });
  const first = paths[0]?.split("/")[0] ?? "";
  const below = paths.every((path) => path.startsWith(`${first}/`));
  const placed: Dropped = new Map();
  files.forEach((file, k) => {
    const path = below ? (paths[k] ?? "").slice(first.length + 1) : (paths[k] ?? file.name);
    placed.set(freePath(path, [...placed.keys()]), file);
  });
  return placed;
}
