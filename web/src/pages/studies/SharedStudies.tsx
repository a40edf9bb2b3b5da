import { Anchor, Stack, Text, Title } from "@mantine/core";
import { Link } from "react-router";

import { useShared } from "../../api/shares";
import { AtRight, Row, Rows } from "../../parts/Rows";
import { When } from "../../parts/When";

/** What other labs let this one read; nothing where there is none. */
export function SharedStudies() {
  const { data } = useShared();
  if (!data || data.items.length === 0) return null;
  return (
    <Stack component="section" gap="sm" mt="xl" aria-labelledby="shared">
      <Title order={2} size="h3" id="shared">
        Shared with your lab
      </Title>
      <Rows>
        {data.items.map((each) => (
          <Row
            key={each.study_id}
            words={
              <>
                <Anchor component={Link} to={`/studies/${each.study_id}`} fw={600}>
                  {each.name}
                </Anchor>
                <Text size="sm" c="dimmed">
                  of {each.lab}
                </Text>
              </>
            }
          >
            <AtRight>
              <When at={each.since} />
            </AtRight>
          </Row>
        ))}
      </Rows>
    </Stack>
  );
}
