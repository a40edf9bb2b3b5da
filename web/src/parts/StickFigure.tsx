import type { RobotModel } from "../api/robots";
import { linkNamed, type Point } from "./place";
import styles from "./StickFigure.module.css";

/** points: places seen from the base link, with the link in whose frame each is written. old: how it was before. */
export type DrawnBand = { name: string; colour: string; points: { place: Point; link: string }[]; old?: boolean };

export const BAND_COLOURS = ["#2466b8", "#b8430d", "#237a3b", "#8e3db0", "#7d6100", "#0b7883"];

type Props = {
  model: RobotModel;
  label: string;
  bands?: DrawnBand[];
  marked?: { band: string; point: number } | null;
  named?: string[];
  pick?: (band: string, point: number) => void;
};

const HEIGHT = 480;
const EDGE = 56;
const TOP = 34;

/** The robot as a stick figure from the front and from its side, all joints at zero, with bands on it. */
export function StickFigure({ model, label, bands = [], marked = null, named = [], pick }: Props) {
  const places = [...model.bones.flat(), ...bands.flatMap((band) => band.points.map(({ place }) => place))];
  const [low, high] = [Math.min, Math.max].map((most) => [0, 1, 2].map((k) => most(...places.map((p) => p[k] ?? 0), 0)));
  const extent = [0, 1, 2].map((k) => Math.max((high?.[k] ?? 0) - (low?.[k] ?? 0), 0.1));
  const scale = HEIGHT / (extent[2] ?? 1);
  const widths = [1, 0].map((axis) => (extent[axis] ?? 0) * scale + 2 * EDGE);
  const width = widths.reduce((sum, each) => sum + each, 0);
  const views = [1, 0].map((axis, k) => ({
    title: axis === 1 ? "From the front" : "From the side",
    left: k === 0 ? 0 : (widths[0] ?? 0),
    at: (p: readonly number[]): [number, number] => [
      (k === 0 ? 0 : (widths[0] ?? 0)) + EDGE + ((p[axis] ?? 0) - (low?.[axis] ?? 0)) * scale,
      TOP + EDGE / 2 + ((high?.[2] ?? 0) - (p[2] ?? 0)) * scale,
    ],
  }));
  const height = TOP + EDGE + HEIGHT;
  return (
    <svg viewBox={`0 0 ${width} ${height}`} className={styles.figure} role="img" aria-label={label}>
      {views.map((view) => (
        <g key={view.title}>
          <text className={styles.title} x={view.left + 12} y={18} fontSize={14}>
            {view.title}
          </text>
          {model.bones.map(([start, end], k) => {
            const [[x1, y1], [x2, y2]] = [view.at(start ?? []), view.at(end ?? [])];
            return <line key={k} className={styles.bone} strokeWidth={4} x1={x1} y1={y1} x2={x2} y2={y2} />;
          })}
          {model.bones.map(([start], k) => {
            const [x, y] = view.at(start ?? []);
            return <circle key={k} className={styles.joint} cx={x} cy={y} r={3} />;
          })}
          {bands.map((band) => (
            <Band key={`${band.name}${band.old ? "~" : ""}`} band={band} at={view.at} model={model} marked={marked} pick={pick} />
          ))}
          {named.map((name) => {
            const link = linkNamed(model, name);
            if (!link) return null;
            const [x, y] = view.at(link.at);
            return (
              <g key={name}>
                <circle className={styles.ring} cx={x} cy={y} r={6} strokeWidth={2} />
                <text className={styles.label} x={x + 10} y={y + 4} fontSize={14}>
                  {name}
                </text>
              </g>
            );
          })}
        </g>
      ))}
      <Scale scale={scale} y={height - 8} />
    </svg>
  );
}

type BandProps = Pick<Props, "model" | "marked" | "pick"> & { band: DrawnBand; at: (p: readonly number[]) => [number, number] };

/** Dotted: from each via point to the origin of the link in whose frame it is written. */
function Band({ band, at, model, marked, pick }: BandProps) {
  const points = band.points.map(({ place }) => at(place));
  return (
    <g>
      {!band.old &&
        band.points.map(({ link }, k) => {
          const origin = linkNamed(model, link)?.at;
          if (!origin) return null;
          const [[x1, y1], [x2, y2]] = [points[k] ?? [0, 0], at(origin)];
          return <line key={k} className={styles.tie} stroke={band.colour} x1={x1} y1={y1} x2={x2} y2={y2} />;
        })}
      <polyline
        className={styles.band}
        data-old={band.old || undefined}
        stroke={band.colour}
        strokeWidth={3}
        points={points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ")}
      />
      {!band.old &&
        points.map(([x, y], k) => {
          const on = marked?.band === band.name && marked.point === k;
          return (
            <g key={k} onClick={() => pick?.(band.name, k)} style={{ cursor: pick ? "pointer" : undefined }}>
              {on && <circle className={styles.ring} cx={x} cy={y} r={12} strokeWidth={2.5} />}
              <circle cx={x} cy={y} r={8} fill={band.colour} />
              <text className={styles.number} x={x} y={y + 4} fontSize={11}>
                {k + 1}
              </text>
            </g>
          );
        })}
    </g>
  );
}

function Scale({ scale, y }: { scale: number; y: number }) {
  const metres = [0.5, 0.2, 0.1, 0.05].find((each) => each * scale < 160) ?? 0.05;
  return (
    <g>
      <line className={styles.scale} x1={12} x2={12 + metres * scale} y1={y} y2={y} strokeWidth={2} />
      <text className={styles.title} x={20 + metres * scale} y={y + 4} fontSize={13}>
        {metres} m
      </text>
    </g>
  );
}
