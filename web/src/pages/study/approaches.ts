import type { Approach } from "./results";

/** In the order in which they are shown. */
export const APPROACHES: { key: Approach; words: string; look: "support_a" | "support_b" | "prior" | "band_model" }[] = [
  { key: "A", words: "A", look: "support_a" },
  { key: "B", words: "B", look: "support_b" },
  { key: "prior", words: "B, maker’s values", look: "prior" },
  { key: "band_model", words: "Band model", look: "band_model" },
];
