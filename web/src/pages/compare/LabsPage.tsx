import { Anchor, NativeSelect, Stack, Table, Text, Title } from "@mantine/core";
import { Link, useSearchParams } from "react-router";

import { useComparedDevice, useComparedDevices, type ComparedDevice, type WornIn } from "../../api/betweenLabs";
import { between } from "../../parts/digits";
import { Empty } from "../../parts/Empty";
import { LinkButton } from "../../parts/LinkButton";
import { Loading } from "../../parts/Loading";
import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import { count } from "../../parts/size";
import { Uncertain } from "../../parts/Uncertain";
import { When } from "../../parts/When";
import { number, WideTable } from "../../parts/WideTable";
import { Agreements } from "./Agreements";
import { approachShort } from "./heads";

/** One device in several labs: who wore it on what, what each found, and whether they agree. */
export function Component() {
  const { data: devices, error, refetch } = useComparedDevices();
  const [search, setSearch] = useSearchParams();
  const first = devices?.items[0];
  const model = search.get("model") ?? first?.model ?? "";
  const size = search.has("model") ? search.get("size") : (first?.size ?? null);
  const found = useComparedDevice(model, size);
  if (error && !devices) return <ProblemBox error={error} retry={() => void refetch()} />;
  if (!devices) return <Loading what="the devices" />;
  const chosen = devices.items.findIndex((each) => each.model === model && each.size === size);
  const choose = (k: number) => {
    const wanted = devices.items[k]!;
    setSearch({ model: wanted.model, ...(wanted.size !== null && { size: wanted.size }) }, { replace: true, preventScrollReset: true });
  };
  return (
    <>
      <PageTitle
        title="One device in several labs"
        lead="Every study that you may see: your lab’s, those shared with it, those published. A device is the same by model and size of its device.yaml, or by its name where no model is stated."
      >
        <LinkButton variant="default" to="/compare">
          Evaluations side by side
        </LinkButton>
      </PageTitle>
      {devices.items.length === 0 ? (
        <Empty title="No device was worn yet">
          <Text>A device is compared once a study that wore it has been evaluated.</Text>
        </Empty>
      ) : (
        <Stack gap="xl">
          <NativeSelect
            label="Device" maw="32rem" value={String(chosen)} onChange={(event) => choose(Number(event.currentTarget.value))}
            data={devices.items.map((each, k) => ({
              value: String(k),
              label: `${each.model}${each.size ? `, size ${each.size}` : ""}: ${count(each.labs, "lab")}, ${count(each.studies, "study", "studies")}`,
            }))}
          />
          {found.error ? (
            <ProblemBox error={found.error} retry={() => void found.refetch()} />
          ) : found.data ? (
            <>
              <Agreements device={found.data} />
              <Worn device={found.data} />
              <Bands device={found.data} />
              <Torques device={found.data} />
            </>
          ) : (
            <Loading what="the studies" />
          )}
        </Stack>
      )}
    </>
  );
}

function name(each: WornIn) {
  if (each.study_id) return <Anchor component={Link} to={`/studies/${each.study_id}`} size="sm">{each.study}</Anchor>;
  return each.published ? <Anchor href={each.published} size="sm">{each.study}</Anchor> : each.study;
}

const SEEN: Record<WornIn["seen"], string> = { own: "yours", shared: "shared with you", published: "published" };

function Worn({ device }: { device: ComparedDevice }) {
  return (
    <Part id="worn" title="Who wore it">
      <WideTable label="Who wore it" columns={["Lab", "Study", "Robot", "Specimen", "How it was worn", "Evaluated", "Seen as"]}>
        {device.studies.map((each, k) => (
          <Table.Tr key={k}>
            <Table.Th scope="row">{each.lab}</Table.Th>
            <Table.Td>{name(each)}</Table.Td>
            <Table.Td>{each.robot}{each.synthetic && ", synthetic"}</Table.Td>
            <Table.Td>{each.specimen.serial ?? "not stated"}</Table.Td>
            <Table.Td>{["straps", "pretension", "garment"].map((key) => each.specimen[key]).filter(Boolean).join("; ") || "not stated"}</Table.Td>
            <Table.Td><When at={each.at} /></Table.Td>
            <Table.Td>{SEEN[each.seen]}{each.seen !== "published" && each.published && ", published"}</Table.Td>
          </Table.Tr>
        ))}
      </WideTable>
    </Part>
  );
}

function Bands({ device }: { device: ComparedDevice }) {
  const quantities = [number("Stiffness ± std"), number("95 %", "N/m"), number("Natural length ± std"), number("95 %", "m")];
  return (
    <Part id="bands" title="Stiffness and natural length">
      <WideTable label="Stiffness and natural length" columns={["Lab", "Study", "Band", "Approach", ...quantities]}>
        {device.studies.flatMap((each, k) =>
          each.bands.map((band) => (
            <Table.Tr key={`${k} ${band.band}`}>
              <Table.Th scope="row">{each.lab}</Table.Th>
              <Table.Td>{name(each)}</Table.Td>
              <Table.Td>{band.group === band.band ? band.band : `${band.band}, group ${band.group}`}</Table.Td>
              <Table.Td>{approachShort(band.approach)}</Table.Td>
              <Table.Td data-number>{band.identifiable ? <Uncertain {...band.stiffness_n_per_m} /> : "not decided"}</Table.Td>
              <Table.Td data-number>{band.identifiable ? between(band.stiffness_interval) : ""}</Table.Td>
              <Table.Td data-number>{band.length_identifiable ? <Uncertain {...band.natural_length_m} /> : "not decided"}</Table.Td>
              <Table.Td data-number>{band.length_identifiable ? between(band.length_interval) : ""}</Table.Td>
            </Table.Tr>
          )),
        )}
      </WideTable>
    </Part>
  );
}

function Torques({ device }: { device: ComparedDevice }) {
  return (
    <Part id="torques" title="Supporting torque">
      <WideTable label="Supporting torque" columns={["Lab", "Study", "Robot", "Motion", "Joint", "Approach", number("Peak ± std"), number("Mean ± std")]}>
        {device.studies.flatMap((each, k) =>
          each.torques.map((torque) => (
            <Table.Tr key={`${k} ${torque.motion} ${torque.joint}`}>
              <Table.Th scope="row">{each.lab}</Table.Th>
              <Table.Td>{name(each)}</Table.Td>
              <Table.Td>{each.robot}</Table.Td>
              <Table.Td>{torque.motion}</Table.Td>
              <Table.Td>{torque.joint}</Table.Td>
              <Table.Td>{approachShort(torque.approach)}</Table.Td>
              <Table.Td data-number><Uncertain {...torque.peak} /></Table.Td>
              <Table.Td data-number>{torque.mean && <Uncertain {...torque.mean} />}</Table.Td>
            </Table.Tr>
          )),
        )}
      </WideTable>
    </Part>
  );
}

function Part({ id, title, children }: { id: string; title: string; children: React.ReactNode }) {
  return (
    <section aria-labelledby={id}>
      <Title order={2} size="h3" id={id} mb="sm">
        {title}
      </Title>
      {children}
    </section>
  );
}
