/** A plot whose canvas the processor draws.

uPlot asks for its canvas without a word, and the browser then draws with the graphics card. Our lines are thousands of short
strokes, which a card is slow at, and where there is none Chromium imitates one: six plots took seconds that take 0.1 s so.
*/

import uPlot from "uplot";

export function madePlot(options: uPlot.Options, data: uPlot.AlignedData, room: HTMLElement): uPlot {
  const canvas = HTMLCanvasElement.prototype;
  const before = canvas.getContext;
  canvas.getContext = function (this: HTMLCanvasElement, kind: string) {
    return before.call(this, kind, kind === "2d" ? { willReadFrequently: true } : undefined);
  } as typeof before;
  try {
    return new uPlot(options, data, room);
  } finally {
    canvas.getContext = before;
  }
}
