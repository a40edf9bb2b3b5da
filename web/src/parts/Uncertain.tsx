import { NONE, plusMinus, unitOf } from "./digits";

type Props = { value?: number | null; std?: number | null; unit?: string | null };

/** value ± standard deviation, with as many digits as they deserve. */
export function Uncertain({ value, std, unit }: Props) {
  const shown = plusMinus(value, std);
  const name = unitOf(unit);
  return (
    <span style={{ whiteSpace: "nowrap", fontVariantNumeric: "tabular-nums" }}>
      {shown}
      {name && shown !== NONE && `\u00a0${name}`}
    </span>
  );
}
