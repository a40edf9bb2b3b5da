/** Hand files in: each by a resumable upload, a few at a time; then they become a study, or a payload. */

import { onceSignedIn } from "../../api/reachable";
import { upload } from "../../api/upload";
import type { Uploaded } from "./handedIn";
import type { Picked } from "./picked";

/** sent: confirmed bytes of each file; reading: all have arrived, and the service looks at them. */
export type Progress = { sent: number[]; reading: boolean };

type Telling = (progress: Progress) => void;

const AT_A_TIME = 3;

/** keep: makes of the uploads what they are. */
export async function send<T>(
  files: readonly Picked[],
  tell: Telling,
  signal: AbortSignal,
  keep: (uploaded: Uploaded, signal: AbortSignal) => Promise<T>,
): Promise<T> {
  const stopper = new AbortController(); // one refused file stops the others
  signal.addEventListener("abort", () => stopper.abort());
  const sent = files.map(() => 0);
  const ids = files.map(() => "");
  let next = 0;

  async function line(): Promise<void> {
    for (let k = next++; k < files.length; k = next++) {
      const { file, path } = files[k] as Picked;
      const told = (bytes: number) => {
        sent[k] = bytes;
        tell({ sent: [...sent], reading: false });
      };
      ids[k] = await upload(file, path, told, stopper.signal);
      told(file.size);
    }
  }

  try {
    await Promise.all(Array.from({ length: Math.min(AT_A_TIME, files.length) }, line));
  } catch (error) {
    stopper.abort();
    throw error;
  }
  tell({ sent, reading: true });
  const body = { upload_ids: ids, paths: files.map(({ path }) => path) };
  return onceSignedIn(() => keep(body, signal), signal);
}
