import { Button, Checkbox, Group, NativeSelect, Stack, Table, Text } from "@mantine/core";

import { NumberField } from "../../../parts/NumberField";
import { number, WideTable } from "../../../parts/WideTable";
import { figure } from "../../../parts/digits";
import { newPlan, wayOf, XYZ, type Cap, type PlanContent } from "./content";
import { saysOf, type Fault } from "./faults";
import { Beside, Together } from "./Fields";
import { Part } from "./SensorStep";
import type { Drafted } from "./useDraft";

const DEGREES = 180 / Math.PI;

/** What may be planned: joints, their limits, where axes of the sensor may point, and what is believed of the payload. */
export function WorkspaceStep({ drafted, faults, tried }: { drafted: Drafted; faults: readonly Fault[]; tried: boolean }) {
  const { draft, set, robot } = drafted;
  const { plan } = draft.content;
  const says = saysOf(faults, tried);
  const change = (next: Partial<PlanContent>) => set((now) => (now.plan ? { ...now, plan: { ...now.plan, ...next } } : now));
  if (wayOf(draft.content) !== "joints") {
    return <Text>Plans need joint angles and a URDF. Yours is a logged pose: go on to the logs that you have recorded.</Text>;
  }
  return (
    <Stack gap="xl">
      <Checkbox
        label="Plan what to record: postures and a motion within these limits"
        description="Without it, go on to the logs that you have."
        checked={plan !== undefined}
        onChange={(event) => {
          const wanted = event.currentTarget.checked;
          set((now) => ({ ...now, plan: wanted ? newPlan(now) : undefined }));
        }}
      />
      {plan && (
        <>
          <Part title="Joints">
            <Text size="sm" c="dimmed">
              Home is where the robot stands before and after, and where joints that do not move stay. Empty limits are the URDF’s.
            </Text>
            {says("plan.home") && <Wrong words={says("plan.home")!} />}
            {says("plan.joints") && <Wrong words={says("plan.joints")!} />}
            <Joints drafted={drafted} plan={plan} change={change} says={says} />
          </Part>
          <Part title="What you believe of the payload">
            <Text size="sm" c="dimmed">
              For the sensor’s range, the joints’ torques and collisions. It is not fitted.
            </Text>
            <Beside>
              <NumberField label="Mass [kg]" w="7rem" value={plan.payload.mass_kg} error={says("plan.payload.mass_kg")} set={(mass_kg) => change({ payload: { ...plan.payload, mass_kg } })} />
              <Together legend="Centre of mass in the sensor’s axes [m]" names={XYZ} values={plan.payload.centre_m} errors={(k) => says(`plan.payload.centre_m.${k}`)} set={(centre_m) => change({ payload: { ...plan.payload, centre_m } })} />
              <Together legend="Size of a box about it [m]" names={XYZ} values={plan.payload.size_m} errors={(k) => says(`plan.payload.size_m.${k}`)} set={(size_m) => change({ payload: { ...plan.payload, size_m } })} />
            </Beside>
          </Part>
          <Part title="Where axes of the sensor may point">
            <Text size="sm" c="dimmed">
              θ is the angle from the base’s +z, so 180° points straight down; φ turns about it. In 3D these are caps on a sphere.
            </Text>
            {says("plan.workspace") && <Wrong words={says("plan.workspace")!} />}
            <Caps caps={plan.workspace ?? []} set={(workspace) => change({ workspace })} says={says} />
          </Part>
        </>
      )}
      {plan && !robot && <Text size="sm">The URDF was not dropped yet.</Text>}
    </Stack>
  );
}

function Wrong({ words }: { words: string }) {
  return (
    <Text size="sm" role="alert" c="var(--mantine-color-error)">
      {words}
    </Text>
  );
}

type JointProps = { drafted: Drafted; plan: PlanContent; change: (next: Partial<PlanContent>) => void; says: (key: string) => string | undefined };

function Joints({ drafted: { draft, robot }, plan, change, says }: JointProps) {
  const names = Object.entries(draft.content.pose.joints ?? {}).filter(([, column]) => column).map(([name]) => name);
  return (
    <WideTable label="Joints of the plan" columns={["Joint", "Moves", number("Home", "rad"), number("at home", "°"), number("From", "rad"), number("To", "rad"), number("Velocity", "rad/s"), number("Acceleration", "rad/s²"), number("Torque", "N·m")]}>
      {names.map((name) => {
        const moves = plan.joints.includes(name);
        const stated = robot?.joints.find((each) => each.name === name);
        const range = plan.position?.[name] ?? [];
        const bound = (k: number, value: number | undefined) => {
          const next = [0, 1].map((at) => (at === k ? value : (range[at] ?? (at ? stated?.upper : stated?.lower) ?? undefined)));
          const { [name]: _, ...rest } = plan.position ?? {};
          change({ position: value === undefined ? rest : { ...rest, [name]: next } });
        };
        const one = (key: "velocity" | "acceleration" | "torque", value: number | undefined) => change({ [key]: { ...plan[key], [name]: value } });
        const field = (label: string, value: number | undefined, placeholder: number | null | undefined, put: (value: number | undefined) => void, error?: string) => (
          <Table.Td>
            <NumberField size="xs" w="5.5rem" aria-label={`${label} of ${name}`} placeholder={placeholder == null ? "" : figure(placeholder)} value={value} error={error} set={put} />
          </Table.Td>
        );
        return (
          <Table.Tr key={name}>
            <Table.Th scope="row">{name}</Table.Th>
            <Table.Td>
              <Checkbox
                aria-label={`${name} moves`}
                checked={moves}
                onChange={(event) => {
                  const joints = names.filter((each) => (each === name ? event.currentTarget.checked : plan.joints.includes(each)));
                  const acceleration = Object.fromEntries(joints.map((each) => [each, plan.acceleration[each] ?? 3]));
                  change({ joints, acceleration });
                }}
              />
            </Table.Td>
            {field("Home [rad]", plan.home[name], null, (value) => change({ home: { ...plan.home, [name]: value } }), says(`plan.home.${name}`))}
            <Table.Td data-number>{plan.home[name] === undefined ? "" : figure(plan.home[name] * DEGREES, 3)}</Table.Td>
            {moves ? (
              <>
                {field("Lowest [rad]", range[0], stated?.lower, (value) => bound(0, value), says(`plan.position.${name}`) ?? says(`plan.position.${name}.0`))}
                {field("Highest [rad]", range[1], stated?.upper, (value) => bound(1, value), says(`plan.position.${name}.1`))}
                {field("Velocity", plan.velocity?.[name], stated?.velocity, (value) => one("velocity", value), says(`plan.velocity.${name}`))}
                {field("Acceleration", plan.acceleration[name], null, (value) => one("acceleration", value), says(`plan.acceleration.${name}`))}
                {field("Torque", plan.torque?.[name], stated?.effort, (value) => one("torque", value), says(`plan.torque.${name}`))}
              </>
            ) : (
              <Table.Td colSpan={5}>stays at home</Table.Td>
            )}
          </Table.Tr>
        );
      })}
    </WideTable>
  );
}

function Caps({ caps, set, says }: { caps: Cap[]; set: (caps: Cap[]) => void; says: (key: string) => string | undefined }) {
  const put = (k: number, change: Partial<Cap>) => set(caps.map((cap, at) => (at === k ? { ...cap, ...change } : cap)));
  return (
    <Stack gap="sm">
      {caps.length === 0 && <Text size="sm">Anywhere.</Text>}
      {caps.map((cap, k) => (
        <Group key={k} gap="md" align="flex-end" role="group" aria-label={`Range ${k + 1}`}>
          <NativeSelect label="Axis" w="5rem" value={cap.axis} data={[...XYZ]} onChange={(event) => put(k, { axis: event.currentTarget.value as Cap["axis"] })} />
          <Together legend="θ [°]" names={["from", "to"]} values={cap.theta_deg ?? [0, 180]} errors={(at) => says(`plan.workspace.${k}.theta_deg.${at}`) ?? (at === 0 ? says(`plan.workspace.${k}`) : undefined)} set={(theta_deg) => put(k, { theta_deg })} />
          <Together legend="φ [°]" names={["from", "to"]} values={cap.phi_deg ?? [-180, 180]} errors={(at) => says(`plan.workspace.${k}.phi_deg.${at}`)} set={(phi_deg) => put(k, { phi_deg })} />
          <Button variant="default" aria-label={`Take out range ${k + 1}`} onClick={() => set(caps.filter((_, at) => at !== k))}>
            Take out
          </Button>
        </Group>
      ))}
      <div>
        <Button variant="default" onClick={() => set([...caps, { axis: "z", theta_deg: [120, 180], phi_deg: [-180, 180] }])}>
          Add a range
        </Button>
      </div>
    </Stack>
  );
}
