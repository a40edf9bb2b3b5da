import { Button, Text, Title } from "@mantine/core";
import { useNavigate } from "react-router";

import { useEveryStudy, type Study } from "../../api/studies";
import { partsOf, useTakeRobot } from "../../api/studyParts";
import { ForMembers } from "../../parts/ForMembers";
import { ProblemBox } from "../../parts/ProblemBox";
import { Row, Rows } from "../../parts/Rows";
import { isFound } from "../../parts/useSought";

/** Robots that came with studies and whose files are not in the list, of those that are searched for. words: of the search, may be empty. */
export function RobotsOfStudies({ words }: { words: string }) {
  const { studies } = useEveryStudy({ robot_id: "none" });
  const take = useTakeRobot();
  const navigate = useNavigate();
  const found = new Map<string, Study>();
  for (const study of studies) {
    const name = partsOf(study).robot?.name;
    if (name && !found.has(name) && isFound(words, name)) found.set(name, study);
  }
  if (found.size === 0) return null;
  return (
    <section aria-labelledby="robots-of-studies">
      <Title order={2} size="h3" id="robots-of-studies" mb="sm">
        In your studies
      </Title>
      {take.error && <ProblemBox error={take.error} />}
      <Rows>
        {[...found].map(([name, study]) => (
          <Row
            key={name}
            words={
              <>
                <Text fw={600}>{name}</Text>
                <Text size="sm" c="dimmed">
                  of the study {study.name}
                </Text>
              </>
            }
          >
            <ForMembers>
            <Button
              variant="default"
              loading={take.isPending && take.variables.id === study.id}
              onClick={() => take.mutate(study, { onSuccess: (robot) => void navigate(`/robots/${robot.id}`) })}
            >
              Add it to the list
            </Button>
            </ForMembers>
          </Row>
        ))}
      </Rows>
    </section>
  );
}
