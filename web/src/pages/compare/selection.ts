/** What is compared and how it is shown, kept in the page's address, so that a link brings it back. */

import { useEffect, useMemo, useState } from "react";
import { useSearchParams } from "react-router";

export type Quantity = "peak" | "mean" | "integral" | "rmse";
export type Selection = {
  jobs: string[];
  quantity: Quantity;
  motion: string;
  joint: string;
  every: boolean;
  differing: boolean;
};

const QUANTITIES: Quantity[] = ["peak", "mean", "integral", "rmse"];

export function useSelection(): [Selection, (change: Partial<Selection>) => void] {
  const [search, setSearch] = useSearchParams();
  const [ahead, setAhead] = useState<Selection | null>(null); // what was just chosen, until the address has it
  useEffect(() => setAhead(null), [search]);
  const now = useMemo(() => ahead ?? read(search), [ahead, search]);
  const change = (part: Partial<Selection>) => {
    const next = { ...now, ...part };
    setAhead(next);
    setSearch(written(next), { replace: true, preventScrollReset: true });
  };
  return [now, change];
}

function read(search: URLSearchParams): Selection {
  const said = search.get("show") as Quantity;
  return {
    jobs: [...new Set(search.getAll("jobs"))],
    quantity: QUANTITIES.includes(said) ? said : "peak",
    motion: search.get("motion") ?? "",
    joint: search.get("joint") ?? "",
    every: search.has("every"),
    differing: search.has("differing"),
  };
}

function written({ jobs, quantity, motion, joint, every, differing }: Selection): URLSearchParams {
  const search = new URLSearchParams(jobs.map((job) => ["jobs", job]));
  if (quantity !== "peak") search.set("show", quantity);
  if (motion) search.set("motion", motion);
  if (joint) search.set("joint", joint);
  if (every) search.set("every", "");
  if (differing) search.set("differing", "");
  return search;
}
