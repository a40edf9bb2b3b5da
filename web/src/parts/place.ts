/** Places on a robot with all joints at zero. */

import type { RobotLink, RobotModel } from "../api/robots";

export type Point = [number, number, number];

/** Where `xyz`, given in the link's own frame, is seen from the base link. [m] */
export function placeOn(link: RobotLink, xyz: readonly number[]): Point {
  const { at, turn } = link;
  const row = (k: number) =>
    (at[k] ?? 0) + [0, 1, 2].reduce((sum, j) => sum + (turn[3 * k + j] ?? 0) * (xyz[j] ?? 0), 0);
  return [row(0), row(1), row(2)];
}

/** A direction or step seen from the base link, as the link's own frame has it. */
export function stepOn(link: RobotLink, step: readonly number[]): Point {
  const column = (k: number) => [0, 1, 2].reduce((sum, j) => sum + (link.turn[3 * j + k] ?? 0) * (step[j] ?? 0), 0);
  return [column(0), column(1), column(2)];
}

export function linkNamed(model: RobotModel, name: string): RobotLink | undefined {
  return model.links.find((link) => link.name === name);
}

/** [m] of the wire through the points. */
export function lengthOf(points: readonly Point[]): number {
  return points.slice(1).reduce((sum, point, k) => {
    const before = points[k] ?? point;
    return sum + Math.hypot(point[0] - before[0], point[1] - before[1], point[2] - before[2]);
  }, 0);
}
