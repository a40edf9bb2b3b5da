/** Files to the service by tus: in pieces, going on where they were when the line breaks. */

import { DetailedError, Upload } from "tus-js-client";

import { address, root } from "../app/base";
import { answered, failed, onceSignedIn } from "./reachable";
import { noAnswer, refusalOf, Refusal } from "./refusal";
import { tusByFetch } from "./tusByFetch";

const PIECE = 8 * 1024 * 1024;
const AGAIN_MS = [0, 1000, 3000, 5000, 10_000, 20_000];

type Telling = (sent: number) => void;

/** Hand one file in. tell: the bytes that the service has confirmed. Gives the id of the upload.
 *
 * While somebody has to sign in again it waits, and then goes on where it was.
 */
export function upload(file: File, name: string, tell: Telling, signal: AbortSignal): Promise<string> {
  return onceSignedIn(() => sent(file, name, tell, signal), signal);
}

function sent(file: File, name: string, tell: Telling, signal: AbortSignal): Promise<string> {
  return new Promise((resolve, reject) => {
    const sending = new Upload(file, {
      endpoint: address("api/v1/uploads"),
      metadata: { filename: name },
      chunkSize: PIECE,
      httpStack: tusByFetch,
      retryDelays: AGAIN_MS,
      fingerprint: async () => [root.pathname, name, file.size, file.lastModified].join("|"),
      removeFingerprintOnSuccess: true,
      onUploadUrlAvailable: () => {
        sending.url = address(`api/v1/uploads/${idOf(sending.url)}`); // the service may not know its proxy's path
      },
      onChunkComplete: (_piece, confirmed) => {
        answered();
        tell(confirmed);
      },
      onShouldRetry: (error) => !refusalFrom(error).signedOut && mayHelp(error.originalResponse?.getStatus() ?? 0),
      onSuccess: () => resolve(idOf(sending.url)),
      onError: (error) => {
        const refusal = refusalFrom(error);
        failed(refusal);
        reject(refusal);
      },
    });
    signal.addEventListener("abort", () => {
      void sending.abort(true); // what has arrived is removed
      reject(new DOMException("stopped", "AbortError"));
    });
    void sending.findPreviousUploads().then(([before]) => {
      if (before) sending.resumeFromPreviousUpload(before);
      if (!signal.aborted) sending.start();
    });
  });
}

function mayHelp(status: number): boolean {
  return status === 0 || status === 409 || status === 423 || status >= 500;
}

function idOf(url: string | null): string {
  return url?.split("/").filter(Boolean).at(-1) ?? "";
}

function refusalFrom(error: Error | DetailedError): Refusal {
  const { originalResponse: response = null, causingError: cause = null } = error instanceof DetailedError ? error : {};
  if (cause instanceof Refusal) return cause;
  if (!response) return noAnswer();
  let body: unknown = null;
  try {
    body = JSON.parse(response.getBody());
  } catch {
    // an answer of a proxy, in HTML
  }
  return refusalOf(response.getStatus(), "", body);
}
