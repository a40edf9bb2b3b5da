import { PageTitle } from "../../parts/PageTitle";
import { HandIn } from "./HandIn";
import { StudyList } from "./StudyList";

export function Component() {
  return (
    <>
      <PageTitle title="Studies" lead="What a wear does to a robot: hand in its logs, and read the evaluation." />
      <HandIn />
      <StudyList />
    </>
  );
}
