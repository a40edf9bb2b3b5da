import { ProblemBox } from "../parts/ProblemBox";
import { useRobotScene } from "./scenes";
import { Stage } from "./Stage";
import { usePlayer } from "./usePlayer";

/** A robot with all joints at zero. */
export function RestingRobot({ robotId, name }: { robotId: string; name: string }) {
  const scene = useRobotScene(robotId);
  const player = usePlayer(scene.data, () => undefined);
  if (scene.isError) return <ProblemBox error={scene.error} retry={() => void scene.refetch()} />;
  return <Stage player={player} title={`${name} in 3D`} waiting="Drawing the robot …" />;
}
