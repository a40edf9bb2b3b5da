/** What the plots show, kept in the page's address, so that a link holds the view. */

import { useCallback, useEffect, useMemo, useRef } from "react";
import { useSearchParams } from "react-router";

/** show: keys of plots; null where the address leaves it to the page. hide: channels. from, to, at [s].
 * doubts, robot: whether uncertainties and the 3D view are shown. */
export type View = {
  log: string | null;
  show: string[] | null;
  hide: string[];
  from: number | null;
  to: number | null;
  at: number | null;
  doubts: boolean;
  robot: boolean;
};

const NOTHING = "none";

/** Changes that follow each other closely add up: each starts from the last one, whether or not that is shown yet.

prefix: of the names in the address, where a page has other plots beside.
*/
export function useView(prefix = ""): [View, (change: Partial<View>) => void] {
  const [search, setSearch] = useSearchParams();
  const view = useMemo(() => read(search, prefix), [search, prefix]);
  const latest = useRef(search);
  const mine = useRef(new Set<string>());
  useEffect(() => {
    const text = search.toString();
    if (!mine.current.has(text)) latest.current = search;
    if (text === latest.current.toString()) mine.current.clear();
  }, [search]);
  const change = useCallback(
    (wanted: Partial<View>) => {
      const next = written(latest.current, prefix, { ...read(latest.current, prefix), ...wanted });
      latest.current = next;
      mine.current.add(next.toString());
      setSearch(next, { replace: true, preventScrollReset: true });
    },
    [setSearch, prefix],
  );
  return [view, change];
}

function read(search: URLSearchParams, prefix: string): View {
  const one = (key: string) => search.get(prefix + key);
  const show = search.getAll(`${prefix}show`);
  return {
    log: one("log"),
    show: show.length === 0 ? null : show.filter((each) => each !== NOTHING),
    hide: search.getAll(`${prefix}hide`),
    from: number(one("from")),
    to: number(one("to")),
    at: number(one("at")),
    doubts: one("doubts") !== "no",
    robot: one("robot") === "yes",
  };
}

function written(now: URLSearchParams, prefix: string, view: View): URLSearchParams {
  const next = new URLSearchParams(now);
  const set = (key: string, values: (string | number | null)[]) => {
    next.delete(prefix + key);
    for (const value of values) if (value !== null) next.append(prefix + key, String(value));
  };
  set("log", [view.log]);
  set("show", view.show === null ? [] : view.show.length ? view.show : [NOTHING]);
  set("hide", view.hide);
  set("from", [view.from]);
  set("to", [view.to]);
  set("at", [view.at]);
  set("doubts", view.doubts ? [] : ["no"]);
  set("robot", view.robot ? ["yes"] : []);
  return next;
}

function number(text: string | null): number | null {
  if (text === null || text.trim() === "") return null;
  const value = Number(text);
  return Number.isFinite(value) ? value : null;
}
