import { Alert, Button, Checkbox, FileButton, Group, Text } from "@mantine/core";
import { Dropzone } from "@mantine/dropzone";
import { IconFiles, IconFolder } from "@tabler/icons-react";

import type { ReactNode } from "react";

import { limits } from "../../api/limits";
import { useKept } from "../../app/kept";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { count, limitOf } from "../../parts/size";
import { STUDY, type HandedIn } from "./handedIn";
import styles from "./HandIn.module.css";
import { picked } from "./picked";
import { SendingFiles } from "./SendingFiles";
import { useHandIn } from "./useHandIn";

type Props = { of: HandedIn; title: string; atOnce: string; children: ReactNode };

export function HandInStudy() {
  return (
    <HandIn of={STUDY} title="Drop a study here" atOnce="Evaluate at once">
      One zip, a folder, or its files: <code>study.yaml</code>, <code>robot.yaml</code>, the URDF and the logs. Meshes are
      not needed.
    </HandIn>
  );
}

/** Where files are handed in: by a drop, or by a choice of files or of a folder. atOnce: label of what is done then. */
export function HandIn(props: Props) {
  return (
    <ForMembers told>
      <Zone {...props} />
    </ForMembers>
  );
}

function Zone({ of, title, atOnce, children }: Props) {
  const [evaluate, setEvaluate] = useKept("evaluate", true);
  const { state, broken, handIn, stop } = useHandIn(of, evaluate);
  const take = (files: File[]) => void handIn(picked(files));

  if (state.step === "sending") return <SendingFiles files={state.files} progress={state.progress} stop={stop} />;
  return (
    <section aria-labelledby="hand-in">
      <Dropzone
        onDrop={take}
        activateOnClick={false}
        activateOnKeyboard={false}
        tabIndex={-1}
        className={styles.zone}
        classNames={{ inner: styles.inner }}
      >
        <Text id="hand-in" component="h2" fw={600} size="lg">
          {title}
        </Text>
        <Text size="sm">{children}</Text>
        <Group gap="sm" mt="sm">
          <FileButton onChange={take} multiple>
            {(props) => (
              <Button {...props} leftSection={<IconFiles size={16} aria-hidden />}>
                Choose files
              </Button>
            )}
          </FileButton>
          <FileButton onChange={take} multiple inputProps={{ webkitdirectory: "" } as object}>
            {(props) => (
              <Button {...props} variant="default" leftSection={<IconFolder size={16} aria-hidden />}>
                Choose a folder
              </Button>
            )}
          </FileButton>
          <Checkbox
            label={atOnce}
            checked={evaluate}
            onChange={(event) => setEvaluate(event.currentTarget.checked)}
          />
        </Group>
        {limits && (
          <Text size="sm" c="dimmed" mt="xs">
            At most {limitOf(limits.bundle_bytes)} and {limits.bundle_files} files. If the line breaks, sending goes on
            where it was.
          </Text>
        )}
      </Dropzone>
      {state.step === "idle" && broken && (
        <Alert color="gray" variant="outline" title="Choose the same files again" className={styles.refusal}>
          {broken.path}
          {broken.files > 1 && ` and ${count(broken.files - 1, "other file")}`} had not arrived when your session ended. Chosen
          again, sending goes on where it was.
        </Alert>
      )}
      {state.step === "refused" && (
        <div className={styles.refusal}>
          <ProblemBox error={state.error} problem={state.problem} />
        </div>
      )}
    </section>
  );
}
