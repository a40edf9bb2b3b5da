import { Anchor, Code, CopyButton, Table, Tooltip, UnstyledButton, VisuallyHidden } from "@mantine/core";

import type { Schemas } from "../api/client";
import { sizeOf } from "./size";
import { number, WideTable } from "./WideTable";

type Props = { label: string; files: Schemas["FileOut"][]; href?: (path: string) => string };

/** Pinned files, each with its size and hash; to be fetched where there is an address. */
export function FileTable({ label, files, href }: Props) {
  return (
    <WideTable label={label} columns={["File", number("Size"), "SHA-256"]}>
      {files.map((file) => (
        <Table.Tr key={file.path}>
          <Table.Td>
            {href ? (
              <Anchor href={href(file.path)} download>
                {file.path}
              </Anchor>
            ) : (
              file.path
            )}
          </Table.Td>
          <Table.Td data-number>{sizeOf(file.size)}</Table.Td>
          <Table.Td>
            <CopyButton value={file.sha256}>
              {({ copied, copy }) => (
                <Tooltip label={copied ? "Copied" : "Copy the whole hash"}>
                  <UnstyledButton onClick={copy}>
                    <Code>{file.sha256.slice(0, 16)}…</Code>
                    <VisuallyHidden> copy the hash of {file.path}</VisuallyHidden>
                  </UnstyledButton>
                </Tooltip>
              )}
            </CopyButton>
          </Table.Td>
        </Table.Tr>
      ))}
    </WideTable>
  );
}
