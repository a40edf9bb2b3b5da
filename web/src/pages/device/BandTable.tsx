import { Radio, Table, VisuallyHidden } from "@mantine/core";

import type { RobotModel } from "../../api/robots";
import { figure, fixed, NONE } from "../../parts/digits";
import { lengthOf, linkNamed, placeOn } from "../../parts/place";
import { BAND_COLOURS } from "../../parts/StickFigure";
import { number, WideTable } from "../../parts/WideTable";
import { groupOf, stiffnessOf, type Band, type DeviceContent } from "./deviceFile";

type Props = { device: DeviceContent; model: RobotModel; chosen: string; choose: (band: string) => void };

/** Every band at a glance; the chosen one is edited below. */
export function BandTable({ device, model, chosen, choose }: Props) {
  return (
    <WideTable
      label="Bands"
      tight
      columns={[
        "Band",
        "Group",
        number("Stiffness", "N/m"),
        number("Natural length", "m"),
        number("Length now", "m"),
        number("Stretch", "mm"),
      ]}
    >
      {device.bands.map((band, k) => {
        const length = bandLength(band, model);
        const stretch = band.natural_length_m === undefined ? null : 1000 * (length - band.natural_length_m);
        return (
          <Table.Tr key={band.name}>
            <Table.Th scope="row">
              <Radio
                name="band"
                checked={band.name === chosen}
                onChange={() => choose(band.name)}
                label={
                  <span style={{ whiteSpace: "nowrap" }}>
                    <svg width={18} height={10} aria-hidden>
                      <line x1={0} x2={18} y1={5} y2={5} strokeWidth={4} stroke={BAND_COLOURS[k % BAND_COLOURS.length]} />
                    </svg>{" "}
                    {band.name}
                    {band.ground_truth && <VisuallyHidden> (ground truth)</VisuallyHidden>}
                  </span>
                }
              />
            </Table.Th>
            <Table.Td>{groupOf(band)}</Table.Td>
            <Table.Td data-number>{figure(stiffnessOf(device, groupOf(band)))}</Table.Td>
            <Table.Td data-number>{fixed(band.natural_length_m, 3)}</Table.Td>
            <Table.Td data-number>{fixed(length, 3)}</Table.Td>
            <Table.Td data-number>{stretch === null ? NONE : `${fixed(stretch, 1)}${stretch > 0 ? "" : " slack"}`}</Table.Td>
          </Table.Tr>
        );
      })}
    </WideTable>
  );
}

/** [m] with all joints at zero. */
export function bandLength(band: Band, model: RobotModel): number {
  return lengthOf(
    band.via_points.flatMap(({ link, xyz }) => {
      const on = linkNamed(model, link);
      return on ? [placeOn(on, xyz)] : [];
    }),
  );
}
