import { PageTitle } from "../../parts/PageTitle";
import { HandInStudy } from "./HandIn";
import { SharedStudies } from "./SharedStudies";
import { StudyList } from "./StudyList";

export function Component() {
  return (
    <>
      <PageTitle title="Studies" lead="What a wear does to a robot: hand in its logs, and read the evaluation." />
      <HandInStudy />
      <StudyList />
      <SharedStudies />
    </>
  );
}
