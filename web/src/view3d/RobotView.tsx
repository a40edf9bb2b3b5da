import type { Cursor } from "../plots/cursor";
import { FollowedView } from "./FollowedView";
import { useRecording } from "./scenes";

/** The robot of one log, with its bands, torques and forces. */
export function RobotView({ jobId, log, cursor }: { jobId: string; log: string; cursor: Cursor }) {
  return <FollowedView scene={useRecording(jobId, log)} name={log} waiting="Drawing the robot …" cursor={cursor} />;
}
