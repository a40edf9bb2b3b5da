import { Button, type ButtonProps } from "@mantine/core";
import { Link, type LinkProps } from "react-router";

/** A link within the app that looks like a button. */
export function LinkButton(props: ButtonProps & Omit<LinkProps, "color" | "style">) {
  return <Button component={Link} {...props} />;
}
