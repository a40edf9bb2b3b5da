import type { Cursor } from "../plots/cursor";
import { FollowedView } from "./FollowedView";
import { useMotionScene, usePlanScene } from "./scenes";

/** What is planned, on its robot, beside the person whose motion it was. */
export function PlanView({ planId, jobId, name, cursor }: { planId: string; jobId: string; name: string; cursor: Cursor }) {
  return <FollowedView scene={usePlanScene(planId, jobId)} name={name} waiting="Drawing the robot and the person …" cursor={cursor} />;
}

/** A person as it was captured. about: what the drawing depends on. */
export function CaptureView({ motionId, about, name, cursor }: { motionId: string; about: string; name: string; cursor: Cursor }) {
  return <FollowedView scene={useMotionScene(motionId, about)} name={name} waiting="Drawing the person …" cursor={cursor} />;
}
