import { Table, Text } from "@mantine/core";

import type { Payload, PayloadResults, Value } from "../../api/payloads";
import { between, NONE, significant, withStd } from "../../parts/digits";
import { Uncertain } from "../../parts/Uncertain";
import { number, WideTable } from "../../parts/WideTable";

const METHODS = ["ls", "tls", "gtls"] as const;
export const NAMES: Record<string, string> = {
  m: "mass m", mx: "m c_x", my: "m c_y", mz: "m c_z", cx: "centre c_x", cy: "centre c_y", cz: "centre c_z",
  fx0: "zero f_x", fy0: "zero f_y", fz0: "zero f_z", mx0: "zero τ_x", my0: "zero τ_y", mz0: "zero τ_z",
  U: "inclination U", V: "inclination V",
};

type Row = { value: Value; still: Value | undefined; methods: Record<string, number | undefined>; truth: number | null };

/** The columns of the paper's table: reference, postures alone, each method, and what is used with its doubt. */
export function ValueTable({ payload, results }: { payload: Payload; results: PayloadResults }) {
  const rows = rowsOf(results, payload.summary.ground_truth.mass_kg);
  const truth = rows.some((row) => row.truth !== null);
  const columns = [
    "Quantity",
    "Unit",
    ...(truth ? [number("Reference")] : []),
    ...(results.dynamic ? [number("Postures alone")] : []),
    ...METHODS.map((method) => number(method.toUpperCase())),
    number("Used ± std"),
    number("95 % interval"),
    ...(truth ? [number("Error")] : []),
    "Remark",
  ];
  return (
    <>
      <WideTable label="Identified values" columns={columns}>
        {rows.map(({ value, still, methods, truth: reference }) => (
          <Table.Tr key={value.name} data-value={value.name}>
            <Table.Th scope="row">{NAMES[value.name] ?? value.name}</Table.Th>
            <Table.Td>{value.unit}</Table.Td>
            {truth && <Table.Td data-number>{reference === null ? NONE : significant(reference, 5)}</Table.Td>}
            {results.dynamic && (
              <Table.Td data-number>
                <Uncertain value={still?.value} std={still?.std} />
              </Table.Td>
            )}
            {METHODS.map((method) => (
              <Table.Td key={method} data-number>
                {alike(methods[method], value.std)}
              </Table.Td>
            ))}
            <Table.Td data-number>
              <Uncertain value={value.value} std={value.std} />
            </Table.Td>
            <Table.Td data-number>{between([value.low, value.high])}</Table.Td>
            {truth && <Table.Td data-number>{reference === null ? NONE : significant(value.value - reference, 2)}</Table.Td>}
            <Table.Td>{value.identified ? "" : "not decided"}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
      <Text size="sm" c="dimmed" mt={4} style={{ maxWidth: "60rem" }}>
        ± is one standard deviation. I are moments and products of inertia about the sensor’s origin. LS: least squares; TLS,
        GTLS: total least squares, plain and with the covariance of the pose’s noise.
        {results.dynamic && ` Used: ${results.dynamic.method.toUpperCase()}.`}
        {" "}“Not decided” means that these motions leave it open.
      </Text>
    </>
  );
}

/** A method's value to the place of the used one's std. */
function alike(value: number | undefined, std: number): string {
  if (value === undefined) return NONE;
  return withStd(value, std)[0];
}

function rowsOf({ static: still, dynamic: moved }: PayloadResults, mass: number | null): Row[] {
  const before = new Map((still?.values ?? []).map((value) => [value.name, value]));
  const tilt = (still?.values ?? []).filter(({ name }) => name === "U" || name === "V");
  const used = moved ? [...moved.values, ...tilt] : (still?.values ?? []);
  return used.map((value) => {
    const inMotion = moved?.values.includes(value) ?? false;
    const by = (inMotion ? moved?.by_method : still?.by_method) ?? {};
    const methods = Object.fromEntries(METHODS.map((method) => [method, by[method]?.[value.name]]));
    return { value, still: before.get(value.name) ?? moment(value.name, still), methods, truth: value.name === "m" ? mass : null };
  });
}

/** m c of what the postures told, with the std that their covariance gives it. */
function moment(name: string, still: PayloadResults["static"]): Value | undefined {
  const axis = /^m([xyz])$/.exec(name)?.[1];
  const place = (wanted: string) => still?.values.findIndex((value) => value.name === wanted) ?? -1;
  const [at, by] = [place("m"), place(`c${axis}`)];
  const [m, c] = [still?.values[at], still?.values[by]];
  if (!axis || !still || !m || !c) return undefined;
  const covariance = still.covariance[at]?.[by] ?? 0;
  const variance = (m.value * c.std) ** 2 + (c.value * m.std) ** 2 + 2 * m.value * c.value * covariance;
  return { ...c, name, value: m.value * c.value, std: Math.sqrt(Math.max(variance, 0)) };
}
