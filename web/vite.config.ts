import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

declare const process: { env: Record<string, string | undefined> };

const SERVICE = process.env.EXOGAUGE_URL ?? "http://127.0.0.1:8765";

// Every address in the build is relative: the service may stand below any path of a proxy.
export default defineConfig({
  base: "./",
  plugins: [react()],
  build: { target: "es2023", assetsInlineLimit: 0, chunkSizeWarningLimit: 900 },
  server: {
    // The service refuses changes that come from a page of another origin; in development that page is ours.
    proxy: Object.fromEntries(
      ["/api", "/healthz", "/readyz"].map((path) => [
        path,
        {
          target: SERVICE,
          changeOrigin: true,
          headers: { origin: SERVICE },
        },
      ]),
    ),
  },
});
