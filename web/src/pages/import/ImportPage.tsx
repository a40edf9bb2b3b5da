import { Alert, Anchor, Button, Code, Group, NativeSelect, Paper, Progress, Stack, Text, Title } from "@mantine/core";
import { useMemo } from "react";
import { Link, useSearchParams } from "react-router";

import type { Schemas } from "../../api/client";
import { useRobot, useRobots } from "../../api/robots";
import { useKept } from "../../app/kept";
import { ForMembers } from "../../parts/ForMembers";
import { DropFiles } from "../../parts/DropFiles";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { sizeOf } from "../../parts/size";
import { ColumnTable } from "./ColumnTable";
import { Findings } from "./Findings";
import { MappingText } from "./MappingText";
import { MappingTools } from "./MappingTools";
import { SensorFrames } from "./SensorFrames";
import { StoreLog } from "./StoreLog";
import { StudyForm } from "./StudyForm";
import { useMapping, useUploading } from "./useImport";
import { Verdict } from "./Verdict";

const FORMATS = ".csv,.txt,.tsv,.gz,.parquet,.mat,.h5,.hdf5,.npz,.npy,.db3,.mcap";

export function Component() {
  return (
    <ForMembers told>
      <Importing />
    </ForMembers>
  );
}

function Importing() {
  const [search] = useSearchParams();
  const { data: robots = [] } = useRobots();
  const [chosen, choose] = useKept("robot", search.get("robot") ?? "");
  const robot = useRobot(chosen || robots[0]?.id);
  const robotId = chosen === "none" ? undefined : robot.data?.id;
  const { sending, uploadId, send, stop, forget } = useUploading();
  const [stored, setStored] = useKept<Schemas["LogOut"][]>("stored", []);
  return (
    <>
      <PageTitle
        title="Import logs"
        lead="Say what the columns of a controller’s own log are. What nothing is said of is refused, never guessed."
      />
      <Stack gap="xl">
        <Paper withBorder p="md">
          <Group align="flex-end" gap="lg">
            <NativeSelect
              label="Robot"
              description="Its joints and limits tell what a column can be; its mapping is remembered."
              value={chosen === "none" ? "none" : (robot.data?.id ?? "")}
              onChange={(event) => choose(event.currentTarget.value)}
              data={[
                ...robots.map((each) => ({ value: each.id, label: `${each.name}, version ${each.version}` })),
                { value: "none", label: "None" },
              ]}
            />
            {robots.length === 0 && (
              <Text size="sm">
                No robot is in the list: <Anchor component={Link} to="/robots" inherit underline="always">hand one in</Anchor> first.
              </Text>
            )}
          </Group>
        </Paper>
        {sending && sending.error === null ? (
          <Paper withBorder p="md" role="status">
            <Group justify="space-between">
              <Text>
                {sending.file.name}: {sizeOf(sending.sent)} of {sizeOf(sending.file.size)}
              </Text>
              <Button variant="default" onClick={stop}>
                Stop
              </Button>
            </Group>
            <Progress aria-label={sending.file.name} value={sending.file.size ? (100 * sending.sent) / sending.file.size : 100} mt="sm" />
          </Paper>
        ) : (
          <DropFiles
            title={uploadId ? "Another file" : "Drop a log"}
            choose="Choose a file"
            single
            accept={FORMATS}
            take={(files) => {
              const [file] = [...files.values()];
              if (file) void send(file);
            }}
          >
            CSV and other text tables, Parquet, MATLAB <Code>.mat</Code>, HDF5, NumPy or rosbag2; as the controller wrote it.
          </DropFiles>
        )}
        {sending?.error != null && <ProblemBox error={sending.error} retry={() => void send(sending.file)} />}
        {uploadId && (
          <OneFile
            key={uploadId}
            uploadId={uploadId}
            robotId={robotId}
            joints={robotId ? (robot.data?.summary.joints ?? []) : []}
            sensors={robotId ? (robot.data?.summary.sensors ?? []) : []}
            stored={(log) => {
              setStored((before) => [...before, log]);
              forget();
            }}
          />
        )}
        {stored.length > 0 && (
          <Alert color="teal" title={`${stored.at(-1)?.name} is stored`} variant="default">
            Drop the next one, or put what is there into a study below.
          </Alert>
        )}
        <StudyForm robotId={robotId} fresh={stored.map((log) => log.id)} />
      </Stack>
    </>
  );
}

type FileProps = {
  uploadId: string;
  robotId: string | undefined;
  joints: string[];
  sensors: string[];
  stored: (log: Schemas["LogOut"]) => void;
};

function OneFile({ uploadId, robotId, joints, sensors, stored }: FileProps) {
  const known = useMemo(() => joints, [joints.join("\n")]);
  const { first, preview, whole, setWhole, text, setText, mapping, judged, waiting } = useMapping(uploadId, robotId, known);
  if (first.error) return <ProblemBox error={first.error} retry={() => void first.refetch()} />;
  if (!preview || !whole) return <Loading what="the file’s columns" />;
  const answer = judged.data && !judged.isPlaceholderData ? judged.data : undefined;
  const last = judged.data;
  return (
    <>
      <Stack component="section" gap="sm" aria-labelledby="columns">
        <Group justify="space-between" align="flex-end">
          <div>
            <Title order={2} size="h3" id="columns">
              {preview.file}
            </Title>
            <Text size="sm" c="dimmed">
              {preview.rows} rows, {preview.columns.length} columns{preview.header ? "" : ", without a header: they are counted"}
            </Text>
          </div>
          {text === null && <MappingTools preview={preview} whole={whole} set={setWhole} />}
        </Group>
        {text === null && (
          <>
            <ColumnTable preview={preview} whole={whole} set={setWhole} joints={known} sensors={sensors} errors={last?.errors ?? []} />
            <SensorFrames preview={preview} whole={whole} set={setWhole} />
          </>
        )}
        <MappingText mapping={mapping} text={text} set={setText} />
      </Stack>
      {judged.error && !judged.isFetching && <ProblemBox error={judged.error} />}
      <Verdict answer={last} waiting={waiting} preview={preview} />
      {last && last.findings.length > 0 && <Findings findings={last.findings} />}
      <StoreLog
        uploadId={uploadId}
        robotId={robotId}
        mapping={mapping}
        ready={!waiting && answer?.complete === true}
        stored={stored}
      />
    </>
  );
}
