/** What this installation takes, as the document says; nothing while the page is developed without the service. */

export type Limits = { upload_bytes: number; bundle_bytes: number; bundle_files: number };

function read(): Limits | null {
  const said = document.querySelector<HTMLMetaElement>('meta[name="limits"]')?.content;
  try {
    return said ? (JSON.parse(said) as Limits) : null;
  } catch {
    return null;
  }
}

export const limits = read();
