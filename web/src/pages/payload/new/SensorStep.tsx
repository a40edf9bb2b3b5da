import { Button, Checkbox, Code, Group, NativeSelect, Radio, Stack, Table, Text, TextInput, Title } from "@mantine/core";
import type { ReactNode } from "react";

import { NumberField } from "../../../parts/NumberField";
import { WideTable } from "../../../parts/WideTable";
import { AddFiles } from "./AddFiles";
import { ColumnTable, Units } from "./ColumnTable";
import { wayOf, withWay, XYZ, type Content, type Way } from "./content";
import { saysOf, type Fault } from "./faults";
import { Beside, Together } from "./Fields";
import type { Drafted } from "./useDraft";

type Props = { drafted: Drafted; faults: readonly Fault[]; tried: boolean };

/** The sensor, where it is, and which columns of a log say so. */
export function SensorStep({ drafted, faults, tried }: Props) {
  const { draft, set, look, robot, add, remove } = drafted;
  const { content } = draft;
  const { sensor, pose } = content;
  const says = saysOf(faults, tried);
  const way = wayOf(content);
  const ofSensor = (change: Partial<Content["sensor"]>) => set((now) => ({ ...now, sensor: { ...now.sensor, ...change } }));
  const ofPose = (change: Partial<Content["pose"]>) => set((now) => ({ ...now, pose: { ...now.pose, ...change } }));
  const used = new Set([pose.urdf, ...content.logs.flatMap(({ file }) => file)]);
  return (
    <Stack gap="xl">
      <Part title="What it is">
        <TextInput
          label="Name of the payload"
          description="Other files under the same name become its next version."
          maw="26rem"
          value={content.name ?? ""}
          maxLength={200}
          error={says("name")}
          onChange={(event) => {
            const name = event.currentTarget.value;
            set((now) => ({ ...now, name }));
          }}
        />
      </Part>
      <Part title="Files">
        <AddFiles title="Drop the robot’s URDF and one of your logs" take={add}>
          The URDF is needed where the pose comes from joint angles, and for plans. A log tells the names of its columns: CSV,
          Parquet, <Code>.mat</Code>, HDF5 or NumPy. Without one, type the names that your logs will have.
        </AddFiles>
        {look?.errors.map((fault, k) => (
          <Text key={k} size="sm" role="alert" c="var(--mantine-color-error)">
            {fault.file}{fault.row ? `, row ${fault.row}` : ""}{fault.column ? `, column ${fault.column}` : ""}: {fault.detail}. {fault.advice}
          </Text>
        ))}
        {draft.files.length > 0 && (
          <WideTable label="Files" columns={["File", "Holds", "Take it out"]}>
            {draft.files.map(({ path }) => (
              <Table.Tr key={path} data-file={path}>
                <Table.Th scope="row">{path}</Table.Th>
                <Table.Td>{holds(path, drafted)}{!used.has(path) && look?.logs.some(({ file }) => file === path) ? "; for its columns’ names, it is given a role later" : ""}</Table.Td>
                <Table.Td>
                  <Button size="compact-xs" variant="default" aria-label={`Take out ${path}`} onClick={() => remove(path)}>
                    Take out
                  </Button>
                </Table.Td>
              </Table.Tr>
            ))}
          </WideTable>
        )}
      </Part>
      <Part title="Where the sensor is">
        <Radio.Group label="Its pose comes from" value={way} onChange={(value) => set((now) => withWay(now, value as Way, robot))} error={says("pose")}>
          <Group gap="lg" mt={6}>
            <Radio value="joints" label="joint angles and the URDF" />
            <Radio value="rotation" label="a logged rotation matrix" />
            <Radio value="quaternion" label="a logged quaternion" />
          </Group>
        </Radio.Group>
        <Beside>
          {way === "joints" && (
            <>
              <NativeSelect
                label="Base link"
                description="It does not move; gravity is given in its axes."
                value={pose.base_link ?? ""}
                data={choices(robot?.fixed, pose.base_link)}
                error={says("pose.base_link")}
                onChange={(event) => ofPose({ base_link: event.currentTarget.value })}
              />
              <NativeSelect
                label="Frame of the sensor"
                description="Link or fixed joint of the URDF."
                value={sensor.frame ?? ""}
                data={choices(robot?.frames, sensor.frame)}
                error={says("sensor.frame")}
                onChange={(event) => ofSensor({ frame: event.currentTarget.value })}
              />
            </>
          )}
          {way === "quaternion" && (
            <NativeSelect
              label="Order of the quaternion"
              value={pose.quaternion_order ?? "xyzw"}
              data={[{ value: "xyzw", label: "x y z w" }, { value: "wxyz", label: "w x y z" }]}
              onChange={(event) => {
                const order = event.currentTarget.value;
                ofPose({ quaternion_order: order, quaternion: [...order].map((axis) => `q${axis}`) });
              }}
            />
          )}
          <NumberField
            label="Noise of an angle [rad]"
            description="Standard deviation of one sample, such as 2e-5."
            value={pose.noise_rad}
            error={says("pose.noise_rad")}
            set={(noise_rad) => ofPose({ noise_rad })}
          />
          {way !== "joints" && pose.position && (
            <NumberField label="Noise of the position [m]" description="Standard deviation of one sample." value={pose.noise_m} error={says("pose.noise_m")} set={(noise_m) => ofPose({ noise_m })} />
          )}
        </Beside>
        {way === "joints" && !robot && <Text size="sm">Drop the URDF above: its joints and frames are then offered here.</Text>}
        {way !== "joints" && (
          <Checkbox
            label="The logs hold the sensor’s position as well: an excitation needs it, or an IMU"
            checked={pose.position !== undefined}
            onChange={(event) => ofPose({ position: event.currentTarget.checked ? XYZ.map((axis) => `p${axis}`) : undefined, noise_m: undefined })}
          />
        )}
        <Checkbox
          label="An IMU is fixed to the sensor: its axes and delay are found"
          checked={content.imu !== undefined}
          onChange={(event) => {
            const imu = event.currentTarget.checked ? { acceleration: ["ax", "ay", "az"], unit: "m/s^2" } : undefined;
            set((now) => ({ ...now, imu }));
          }}
        />
        <Together
          legend="Gravity [m/s²]"
          note="In the base link’s axes, as if the base stood level; what it is inclined by is found."
          names={XYZ}
          values={content.gravity}
          errors={(k) => says(`gravity.${k}`) ?? (k === 0 ? says("gravity") : undefined)}
          set={(gravity) => set((now) => ({ ...now, gravity }))}
        />
      </Part>
      <Part title="What the sensor measures">
        <Beside>
          <NativeSelect
            label="It sees"
            description="Postures tell it, and contradict it if it is wrong."
            value={sensor.sees ?? ""}
            data={[
              { value: "", label: "told from the postures" },
              { value: "payload_on_sensor", label: "what the payload does to the sensor" },
              { value: "sensor_on_payload", label: "what the sensor does to the payload" },
            ]}
            onChange={(event) => ofSensor({ sees: event.currentTarget.value || undefined })}
          />
          <NativeSelect
            label="Axes of the wrench’s columns"
            description="Most sensors log in their own."
            value={sensor.axes ?? "sensor"}
            data={[{ value: "sensor", label: "the sensor’s" }, { value: "base", label: "the base link’s" }]}
            onChange={(event) => ofSensor({ axes: event.currentTarget.value })}
          />
          <NumberField label="Noise of a force [N]" description="Standard deviation of one sample." value={sensor.noise.force_n} error={says("sensor.noise.force_n")} set={(force_n) => ofSensor({ noise: { ...sensor.noise, force_n } })} />
          <NumberField label="Noise of a moment [N·m]" description="Standard deviation of one sample." value={sensor.noise.moment_nm} error={says("sensor.noise.moment_nm")} set={(moment_nm) => ofSensor({ noise: { ...sensor.noise, moment_nm } })} />
        </Beside>
        <Checkbox
          label="The sensor’s rated range is known: saturation is looked for, and plans keep within it"
          checked={sensor.range !== undefined}
          onChange={(event) => ofSensor({ range: event.currentTarget.checked ? { force_n: [undefined, undefined, undefined], moment_nm: [undefined, undefined, undefined] } : undefined })}
        />
        {sensor.range && (
          <Beside>
            <Together legend="Rated force [N]" names={XYZ} values={sensor.range.force_n} errors={(k) => says(`sensor.range.force_n.${k}`)} set={(force_n) => ofSensor({ range: { ...sensor.range!, force_n } })} />
            <Together legend="Rated moment [N·m]" names={XYZ} values={sensor.range.moment_nm} errors={(k) => says(`sensor.range.moment_nm.${k}`)} set={(moment_nm) => ofSensor({ range: { ...sensor.range!, moment_nm } })} />
          </Beside>
        )}
      </Part>
      <Part title="Which column is what">
        <Text size="sm" c="dimmed" maw="60rem">
          The same in every log. Names that say it are taken over: check them against the values. Signs and units that do not fit
          are told as soon as a log has a role.
        </Text>
        <Units content={content} set={set} />
        <ColumnTable content={content} set={set} look={look} faults={faults} says={says} />
      </Part>
    </Stack>
  );
}

export function Part({ title, children }: { title: string; children: ReactNode }) {
  return (
    <section aria-label={title}>
      <Title order={3} size="h4" mb="xs">
        {title}
      </Title>
      <Stack gap="sm">{children}</Stack>
    </section>
  );
}

function choices(known: readonly string[] | undefined, chosen: string | undefined) {
  const names = known ?? [];
  const all = chosen && !names.includes(chosen) ? [chosen, ...names] : names;
  return [{ value: "", label: "–" }, ...all.map((name) => ({ value: name, label: name }))];
}

function holds(path: string, { look, looking }: Drafted): string {
  const robot = look?.robots.find(({ file }) => file === path);
  if (robot) return `${robot.joints.length} joints, ${robot.frames.length} frames`;
  const log = look?.logs.find(({ file }) => file === path);
  if (log) return `${log.rows} rows, ${log.columns.length} columns`;
  if (look?.errors.some(({ file }) => file === path)) return "cannot be read";
  return looking ? "is looked at …" : "";
}
