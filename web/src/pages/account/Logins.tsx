import { Button, Stack, Text, Title } from "@mantine/core";

import { useIdentities, useUnlink } from "../../api/oidc";
import { ProblemBox } from "../../parts/ProblemBox";
import { Row, Rows } from "../../parts/Rows";
import { useDeed } from "../../parts/useDeed";
import { When } from "../../parts/When";
import { ProviderButton } from "./ProviderButton";

/** Logins elsewhere by which this account is reached. */
export function Logins() {
  const { data, error } = useIdentities();
  const unlink = useUnlink();
  const { start, busy, error: refused } = useDeed();
  if (error) return <ProblemBox error={error} />;
  if (!data) return null;
  return (
    <Stack component="section" aria-labelledby="logins" gap="sm" align="flex-start">
      <Title order={2} size="h3" id="logins">
        Logins elsewhere
      </Title>
      {data.items.length > 0 && (
        <Rows>
          {data.items.map((each) => (
            <Row
              key={each.id}
              words={
                <>
                  <Text fw={600}>{each.subject}</Text>
                  <Text size="sm" c="dimmed">
                    {each.issuer}, since <When at={each.created_at} />
                  </Text>
                </>
              }
            >
              <Button size="xs" variant="default" loading={busy} onClick={() => start(() => unlink(each.id))}>
                Unlink {each.subject}
              </Button>
            </Row>
          ))}
        </Rows>
      )}
      {refused !== null && <ProblemBox error={refused} />}
      <ProviderButton words="Link a login at" ask={{ purpose: "link", next: "/account" }} />
    </Stack>
  );
}
