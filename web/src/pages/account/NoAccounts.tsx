import { Empty } from "../../parts/Empty";

export function NoAccounts() {
  return (
    <Empty title="There are no accounts here" heading={1}>
      <p>
        Whoever reaches this service may do everything; it listens on its own machine, or something in front of it lets people in.
        Started with <code>EXOGAUGE_ACCOUNTS=1</code> it asks who is there, and labs have members.
      </p>
    </Empty>
  );
}
