import { Paper, Stack } from "@mantine/core";
import type { FormEvent, ReactNode } from "react";

import { PageTitle } from "../../parts/PageTitle";
import { ProblemBox } from "../../parts/ProblemBox";
import styles from "./Doorstep.module.css";

type Props = { title: string; lead?: ReactNode; error?: unknown; onSubmit: () => void; children: ReactNode };

/** A page of one form, for somebody who is not in yet. */
export function Doorstep({ title, lead, error, onSubmit, children }: Props) {
  const submit = (event: FormEvent) => {
    event.preventDefault();
    onSubmit();
  };
  return (
    <div className={styles.place}>
      <PageTitle title={title} lead={lead} />
      <Paper withBorder p="lg">
        <form onSubmit={submit}>
          <Stack>
            {children}
            {error !== null && error !== undefined && <ProblemBox error={error} />}
          </Stack>
        </form>
      </Paper>
    </div>
  );
}
