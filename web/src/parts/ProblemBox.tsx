import { Alert, Button, Code, List, Text } from "@mantine/core";
import { IconAlertTriangle } from "@tabler/icons-react";

import { Refusal, type Problem, type ProblemError } from "../api/refusal";
import styles from "./ProblemBox.module.css";
import { Said } from "./Said";

const MOST = 50;
const LOOK = { root: styles.box, title: styles.title, icon: styles.icon };

type Props = { error?: unknown; problem?: Problem | null; retry?: () => void };

/** Why something was refused or failed: each broken rule with its place, value and advice. */
export function ProblemBox({ error, problem, retry }: Props) {
  const shown = problem ?? (error instanceof Refusal ? error.problem : defect(error));
  const rules = shown.errors ?? [];
  return (
    <Alert role="alert" color="red" icon={<IconAlertTriangle aria-hidden />} title={shown.title} classNames={LOOK}>
      {rules.length !== 1 && <Text size="sm"><Said words={capital(shown.detail)} /></Text>}
      {rules.length > 0 && (
        <List size="sm" mt={rules.length > 1 ? "xs" : 0} spacing={4}>
          {rules.slice(0, MOST).map((rule, k) => (
            <List.Item key={k}>
              <Rule rule={rule} />
            </List.Item>
          ))}
        </List>
      )}
      {rules.length > MOST && <Text size="sm">… and {rules.length - MOST} more of the kind.</Text>}
      {retry && (
        <Button size="xs" variant="default" mt="sm" onClick={retry}>
          Try again
        </Button>
      )}
    </Alert>
  );
}

function Rule({ rule }: { rule: ProblemError }) {
  const place = placeOf(rule);
  return (
    <>
      {place && <strong>{place}: </strong>}
      <Said words={place ? rule.detail : capital(rule.detail)} />
      {rule.value !== null && rule.value !== undefined && (
        <>
          {" "}
          (value: <Code>{rule.value}</Code>)
        </>
      )}
      {/[.!?]$/.test(rule.detail) ? " " : ". "}
      <Said words={capital(rule.advice ?? "")} />
    </>
  );
}

function placeOf(rule: ProblemError): string {
  const parts = [];
  if (rule.file) parts.push(rule.file);
  if (rule.row !== null && rule.row !== undefined) parts.push(`row ${rule.row}`);
  if (rule.column) parts.push(`column ${rule.column}`);
  return parts.join(", ") || rule.pointer || "";
}

/** A first word that is no name: `study.yaml`, `k_T` and `q.elbow` stay as they are. */
export function capital(words: string): string {
  return /^[a-z]+(?=[ ,:’'])/.test(words) ? words.slice(0, 1).toUpperCase() + words.slice(1) : words;
}

function defect(error: unknown): Problem {
  const detail = error instanceof Error ? error.message : String(error);
  return { type: "about:blank", title: "The page failed", status: 0, detail, errors: [] };
}
