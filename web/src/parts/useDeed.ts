import { useRef, useState } from "react";

/** Something that is done once at a time, from the click to its last step. busy: since the click; error: why it ended. */
export function useDeed() {
  const [busy, setBusy] = useState(false);
  const running = useRef(false); // at once, where a second click comes before the page is drawn anew
  const [error, setError] = useState<unknown>(null);
  const run = async (deed: () => Promise<void>) => {
    if (running.current) return;
    running.current = true;
    setBusy(true);
    setError(null);
    try {
      await deed();
    } catch (refused) {
      setError(refused);
    } finally {
      running.current = false;
      setBusy(false);
    }
  };
  return { start: (deed: () => Promise<void>) => void run(deed), busy, error };
}
