/** What this page and the player in its frame say to each other. The frame has an origin of its own and asks nobody else. */

export type LegendEntry = {
  layer: string;
  label: string;
  color: string;
  size: string;
  scale?: string[];
  low?: number;
  high?: number;
  unit?: string;
};

/** A via point that can be dragged: its place [m] in its link's frame. */
export type ViaPoint = { name: string; link: string; band: string; position: number[] };

export type About = {
  log: string;
  start: number;
  end: number;
  fps: number;
  frames: number;
  legend: LegendEntry[];
  marked: { joint: string; effect: string }[];
  notes: string[];
  points?: ViaPoint[];
  layers: string[];
  hidden: string[];
};

export type Said =
  | { type: "ready" }
  | { type: "loaded"; about: About }
  | { type: "time"; time: number; playing: boolean; wish: number }
  | { type: "moved"; point: number; link: string; position: number[]; done: boolean }
  | { type: "chosen"; point: number }
  | { type: "failed"; reason: string };

export type Asked =
  | { type: "scene"; data: ArrayBuffer }
  | { type: "seek"; time: number; wish: number }
  | { type: "play"; speed: number }
  | { type: "pause" }
  | { type: "camera" }
  | { type: "theme"; dark: boolean }
  | { type: "show"; layer: string; visible: boolean }
  | { type: "choose"; point: number }
  | { type: "place"; point: number; position: number[] };

export function ask(frame: HTMLIFrameElement | null, asked: Asked): void {
  frame?.contentWindow?.postMessage(asked, "*"); // its origin is opaque; the frame's policy lets it go nowhere
}

/** Calls `hear` for what this very frame says; returns what ends it. */
export function listen(frame: () => HTMLIFrameElement | null, hear: (said: Said) => void): () => void {
  const heard = (event: MessageEvent) => {
    const source = frame()?.contentWindow;
    if (source && event.source === source && typeof event.data?.type === "string") hear(event.data as Said);
  };
  window.addEventListener("message", heard);
  return () => window.removeEventListener("message", heard);
}
