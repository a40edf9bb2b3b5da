import type { Approach } from "./results";

/** In the order in which they are shown. */
export const APPROACHES: { key: Approach; words: string; look: "support_a" | "support_b" | "support_paired" | "prior" | "band_model" }[] = [
  { key: "A", words: "A", look: "support_a" },
  { key: "B", words: "B", look: "support_b" },
  { key: "paired", words: "Paired", look: "support_paired" },
  { key: "prior", words: "B, maker’s values", look: "prior" },
  { key: "band_model", words: "Band model", look: "band_model" },
];
