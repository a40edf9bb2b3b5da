/** Where the service stands: the address that every other one is relative to, found from the document at run time. */

export const root = new URL("./", document.baseURI);

/** The path below which the router lives, without a slash at its end: "" or "/lab/exo". */
export const basename = root.pathname.replace(/\/$/, "");

/** The full address of a path of the service, such as `api/v1/studies`. */
export function address(path: string): string {
  return new URL(path.replace(/^\//, ""), root).href;
}
