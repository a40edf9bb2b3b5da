/** Hand files in as one request. How much of each has left is told while it is sent. */

import { address } from "../../app/base";
import { newKey } from "../../api/client";
import { answered, failed } from "../../api/reachable";
import { noAnswer, refusalOf } from "../../api/refusal";
import type { Study } from "../../api/studies";
import { totalSize, type Picked } from "./picked";

/** sent: bytes of each file; reading: all have arrived, and the service looks at them. */
export type Progress = { sent: number[]; reading: boolean };

export type HandedIn = { study: Study; isNew: boolean };

type Telling = (progress: Progress) => void;

export function send(files: readonly Picked[], tell: Telling, signal: AbortSignal): Promise<HandedIn> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest(); // fetch cannot say how much was sent
    request.open("POST", address("api/v1/studies"));
    request.setRequestHeader("Idempotency-Key", newKey());
    request.responseType = "json";
    request.upload.onprogress = ({ loaded }) => tell({ sent: shared(loaded, files), reading: false });
    request.upload.onload = () => tell({ sent: files.map(({ file }) => file.size), reading: true });
    request.onerror = () => {
      const refusal = noAnswer();
      failed(refusal);
      reject(refusal);
    };
    request.onabort = () => reject(new DOMException("stopped", "AbortError"));
    request.onload = () => {
      if (request.status < 300) {
        answered();
        resolve({ study: request.response as Study, isNew: request.status === 201 });
      } else {
        reject(refusalOf(request.status, request.statusText, request.response));
      }
    };
    signal.addEventListener("abort", () => request.abort());
    const form = new FormData();
    for (const { file, path } of files) form.append("files", file, path);
    request.send(form);
  });
}

/** The files follow each other in the request, so what was sent belongs to the first ones. */
function shared(loaded: number, files: readonly Picked[]): number[] {
  let left = Math.min(loaded, totalSize(files));
  return files.map(({ file }) => {
    const part = Math.min(left, file.size);
    left -= part;
    return part;
  });
}
