import { PageTitle } from "../../parts/PageTitle";

export function Component() {
  return <PageTitle title="Robots" />;
}
