import styles from "./ForceArrow.module.css";

const SIZE = 200;
const REACH = 74;
const SHORT = 46;
const AXES = ["x", "y", "z"];
const LEAN = Math.PI / 6;
const TIP = 10;

/** The contact force as an arrow in the sensor's axes, seen from a corner. full: [N] of the longest arrow. */
export function ForceArrow({ force, full, touched, label }: { force: number[] | null; full: number; touched: boolean; label: string }) {
  const [x, y] = force ? seen(force.map((each) => (REACH * each) / Math.max(full, 1e-9))) : [0, 0];
  const long = Math.hypot(x, y);
  const [ux, uy] = long > 0 ? [x / long, y / long] : [0, 0];
  return (
    <svg viewBox={`${-SIZE / 2} ${-SIZE / 2} ${SIZE} ${SIZE}`} className={styles.arrow} role="img" aria-label={label}>
      {AXES.map((name, k) => {
        const [ax, ay] = seen(AXES.map((_, other) => (other === k ? SHORT : 0)));
        return (
          <g key={name}>
            <line className={styles.axis} x1={0} y1={0} x2={ax} y2={ay} />
            <text className={styles.name} x={1.25 * ax} y={1.25 * ay}>
              {name}
            </text>
          </g>
        );
      })}
      {force && (
        <g className={touched ? styles.touch : styles.chance} data-touched={touched}>
          <line x1={0} y1={0} x2={x} y2={y} />
          {long > TIP && <polygon points={[[x, y], [x - TIP * ux - 5 * uy, y - TIP * uy + 5 * ux], [x - TIP * ux + 5 * uy, y - TIP * uy - 5 * ux]].join(" ")} />}
        </g>
      )}
    </svg>
  );
}

/** x to the lower left, y to the lower right, z up. */
function seen([x = 0, y = 0, z = 0]: number[]): [number, number] {
  return [(y - x) * Math.cos(LEAN), (x + y) * Math.sin(LEAN) - z];
}
