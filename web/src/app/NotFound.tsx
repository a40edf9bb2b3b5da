import { useLocation } from "react-router";

import { Empty } from "../parts/Empty";
import { LinkButton } from "../parts/LinkButton";

export function NotFound() {
  const { pathname } = useLocation();
  return (
    <Empty title="There is no such page" heading={1}>
      <p>
        Nothing is at <code>{pathname}</code>. The address may be mistyped, or what was here was removed.
      </p>
      <LinkButton to="/studies">To the studies</LinkButton>
    </Empty>
  );
}
