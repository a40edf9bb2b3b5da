import { useComputedColorScheme } from "@mantine/core";
import { useCallback, useEffect, useRef, useState, type RefObject } from "react";

import { ask, listen, type About, type Asked, type Said } from "./player";

const PATIENCE_MS = 30_000;

export type Player = {
  frame: RefObject<HTMLIFrameElement | null>;
  about: About | null;
  playing: boolean;
  failure: string | null;
  ask: (asked: Asked) => void;
};

/** The player in a frame: given its scene as soon as both are there, and the page's colours. onSaid: time and drags. */
export function usePlayer(data: ArrayBuffer | undefined, onSaid: (said: Said) => void): Player {
  const frame = useRef<HTMLIFrameElement | null>(null);
  const [ready, setReady] = useState(false);
  const [about, setAbout] = useState<About | null>(null);
  const [playing, setPlaying] = useState(false);
  const [failure, setFailure] = useState<string | null>(null);
  const dark = useComputedColorScheme("light") === "dark";
  const hear = useRef(onSaid);
  hear.current = onSaid;

  useEffect(() => {
    const patience = window.setTimeout(() => setFailure((known) => known ?? "timeout"), PATIENCE_MS);
    const stop = listen(
      () => frame.current,
      (said) => {
        if (said.type === "ready") {
          window.clearTimeout(patience);
          setReady(true);
          setFailure((known) => (known === "timeout" ? null : known));
        } else if (said.type === "loaded") {
          setAbout(said.about);
          setPlaying(false);
        }
        if (said.type === "failed") setFailure(said.reason);
        else if (said.type === "time") setPlaying(said.playing);
        hear.current(said);
      },
    );
    return () => {
      window.clearTimeout(patience);
      stop();
    };
  }, []);

  const tell = useCallback((asked: Asked) => ask(frame.current, asked), []);
  useEffect(() => {
    if (ready) tell({ type: "theme", dark });
  }, [ready, dark, tell]);
  useEffect(() => {
    setAbout(null);
    if (ready && data) tell({ type: "scene", data });
  }, [ready, data, tell]);

  return { frame, about, playing, failure, ask: tell };
}
