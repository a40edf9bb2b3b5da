import "@mantine/core/styles.css";
import "@mantine/dropzone/styles.css";
import "./app/page.css";

import { MantineProvider, localStorageColorSchemeManager } from "@mantine/core";
import { QueryClientProvider } from "@tanstack/react-query";
import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { RouterProvider } from "react-router/dom";

import { newCache } from "./api/cache";
import { styleNonce } from "./app/nonce";
import { newRouter } from "./app/router";
import { contrast, theme } from "./app/theme";

const schemes = localStorageColorSchemeManager({ key: "exogauge-colour-scheme" });

createRoot(document.getElementById("root") as HTMLElement).render(
  <StrictMode>
    <MantineProvider
      theme={theme}
      cssVariablesResolver={contrast}
      defaultColorScheme="auto"
      colorSchemeManager={schemes}
      getStyleNonce={styleNonce}
    >
      <QueryClientProvider client={newCache()}>
        <RouterProvider router={newRouter()} />
      </QueryClientProvider>
    </MantineProvider>
  </StrictMode>,
);
