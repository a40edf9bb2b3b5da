/** The document's key for style elements made by scripts: the service allows no others. */

import { setNonce } from "get-nonce";

const said = document.querySelector<HTMLMetaElement>('meta[property="csp-nonce"]')?.nonce;

if (said) setNonce(said); // for dialogs, which hold the page's scroll bar with a style of their own

export function styleNonce(): string {
  return said ?? "";
}
