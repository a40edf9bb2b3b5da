import type { NewPublication } from "../../api/publications";

const ORCID = /(\d{4}-){3}\d{3}[\dX]/;

/** A line each: `Family, Given; ORCID; affiliation`, the last two in any order, or left out. */
export function creatorsOf(text: string): NewPublication["creators"] {
  const lines = text.split("\n").map((line) => line.trim()).filter(Boolean);
  return lines.map((line) => {
    const [name = "", ...rest] = line.split(";").map((part) => part.trim());
    const orcid = rest.map((part) => ORCID.exec(part)?.[0]).find(Boolean) ?? null;
    const affiliation = rest.find((part) => part && !ORCID.test(part)) ?? null;
    return { name, orcid, affiliation };
  });
}
