/** Files as a person picked or dropped them: one zip, single files, or a folder with its paths. */

import type { FileWithPath } from "@mantine/dropzone";

import type { Limits } from "../../api/limits";
import type { Problem, ProblemError } from "../../api/refusal";
import { count, limitOf, sizeOf } from "../../parts/size";

export type Picked = { file: File; path: string };

const IGNORED = /(^|\/)(\.DS_Store|Thumbs\.db|__MACOSX\/.*)$/;

/** With the path that a file has in its folder. */
export function picked(files: readonly File[]): Picked[] {
  return files
    .map((file) => {
      const { path, relativePath } = file as FileWithPath & { relativePath?: string };
      const said = file.webkitRelativePath || relativePath || path || file.name;
      return { file, path: said.replace(/^(\.?\/)+/, "") };
    })
    .filter(({ path }) => !IGNORED.test(path));
}

export function isZip(files: readonly Picked[]): boolean {
  return files.length === 1 && /\.zip$/i.test(files[0]?.path ?? "");
}

export function totalSize(files: readonly Picked[]): number {
  return files.reduce((sum, { file }) => sum + file.size, 0);
}

/** What would be refused anyway, said before anything is sent. */
export function refusedBeforehand(files: readonly Picked[], limits: Limits | null, main: string): Problem | null {
  const errors = [...missing(files, main), ...(limits ? tooMuch(files, limits) : [])];
  if (errors.length === 0) return null;
  const detail = `${count(errors.length, "reason")} not to send ${count(files.length, "file")}:`;
  return { type: "about:blank", title: "Nothing was sent", status: 422, detail, errors };
}

function missing(files: readonly Picked[], main: string): ProblemError[] {
  if (files.length === 0) {
    return [rule("no file was found in what was dropped", "empty", "Drop a zip, the files themselves, or their folder.")];
  }
  if (isZip(files) || files.some(({ path }) => path === main || path.endsWith(`/${main}`))) return [];
  const advice = `Drop the folder that holds ${main}, or all of its files at once, or one zip of them.`;
  return [rule(`${main} is not among these files`, "missing_file", advice)];
}

function tooMuch(files: readonly Picked[], limits: Limits): ProblemError[] {
  const found = [];
  const size = totalSize(files);
  if (size > limits.bundle_bytes) {
    const words = `together they have ${sizeOf(size)}, and this service takes ${limitOf(limits.bundle_bytes)}`;
    found.push(rule(words, "too_large", "Leave out what is not needed; logs as Parquet are smaller."));
  }
  if (files.length > limits.bundle_files) {
    const words = `these are ${files.length} files, and this service takes ${limits.bundle_files}`;
    found.push(rule(words, "too_many_files", "Leave out what is not needed."));
  }
  return found;
}

function rule(detail: string, code: string, advice: string): ProblemError {
  return { detail, code, advice, pointer: null, file: null, row: null, column: null, value: null };
}
