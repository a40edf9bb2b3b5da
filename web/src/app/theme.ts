import { createTheme, type CSSVariablesResolver, type MantineColorsTuple } from "@mantine/core";

const petrol: MantineColorsTuple = [
  "#e6f6fa",
  "#d3e9ef",
  "#a8d2de",
  "#79bbcc",
  "#54a7bd",
  "#3c9ab4",
  "#2c94b0",
  "#1b7089",
  "#0b5a6f",
  "#00485a",
];

export const theme = createTheme({
  primaryColor: "petrol",
  primaryShade: { light: 8, dark: 7 },
  colors: { petrol },
  defaultRadius: "md",
  cursorType: "pointer",
  fontFamily: "system-ui, sans-serif",
  fontFamilyMonospace: "ui-monospace, monospace",
  headings: { fontFamily: "system-ui, sans-serif", fontWeight: "650" },
});

/** Quiet text, links and errors with a contrast of at least 4.5 : 1 on either ground. */
export const contrast: CSSVariablesResolver = () => ({
  variables: {},
  light: {
    "--mantine-color-dimmed": "#4f5b61",
    "--mantine-color-placeholder": "#5c676d",
    "--mantine-color-error": "#b02020",
    "--mantine-color-anchor": "#0b5a6f",
  },
  dark: {
    "--mantine-color-dimmed": "#b3bdc2",
    "--mantine-color-placeholder": "#a3adb2",
    "--mantine-color-error": "#ffa8a0",
    "--mantine-color-anchor": "#79cfe6",
  },
});
