"""What a person sees of the 3D view: its picture, and what it tells the page."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.image import imread
from playwright.sync_api import expect

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

Picture = npt.NDArray[np.int16]
DRAWN_MS = 180_000  # without a graphics card, on a busy machine
TRIES = 60
SAME = 12  # of 255: what the rounding of a drawing may differ by
COARSE, ALIKE = 4, 24  # pixels of a side, of 255: a busy view draws with fewer points, and every edge is softer then
HEAR = """window.heard = []; window.addEventListener("message", ({data}) => {
  if (["loaded", "time", "settled"].includes(data?.type)) window.heard.push(data);
});"""
SETTLE = """() => {
  window.heard = window.heard.filter(({type}) => type !== "settled");
  document.querySelector("iframe").contentWindow.postMessage({type: "settle"}, "*");
}"""
SETTLED = "() => window.heard.some(({type}) => type === 'settled')"
STOPPED = "() => window.heard.filter(({type}) => type === 'time').at(-1)?.playing === false"


def listen(page: Page) -> None:
    """Before the page is opened: keep what its 3D view says."""
    page.add_init_script(HEAR)


def said(page: Page, kind: str) -> Any:
    """The last message of that kind."""
    return page.evaluate("(kind) => window.heard.filter(({type}) => type === kind).at(-1)", kind)


def stopped_at(page: Page) -> float:
    """[s] where the robot stands, once it says that it no longer plays."""
    page.wait_for_function(STOPPED)
    return float(said(page, "time")["time"])


def frame(page: Page) -> Locator:
    return page.locator("iframe")


def wait_until_drawn(page: Page) -> None:
    expect(page.frame_locator("iframe").locator("canvas").first).to_be_visible(timeout=DRAWN_MS)
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=DRAWN_MS)


def picture(page: Page) -> Picture:
    """(height, width, 3) the view once all that it was asked for is drawn, and it no longer changes.

    That it does not change is not enough: on a busy machine it stands still before it begins, too.
    """
    page.evaluate(SETTLE)
    page.wait_for_function(SETTLED, timeout=DRAWN_MS)
    before = shot(page)
    for _ in range(TRIES):
        page.wait_for_timeout(500)
        now = shot(page)
        if differing(before, now) == 0.0:
            return now
        before = now
    raise AssertionError("the 3D view does not come to rest")


def is_again(page: Page, before: Picture, share: float = 0.001) -> bool:
    """Whether the view comes to look as it did, but for a share of its parts; a busy machine takes a while."""
    return any(changed(before, picture(page)) < share for _ in range(TRIES))


def shot(page: Page) -> Picture:
    return (255 * imread(io.BytesIO(frame(page).screenshot()))[:, :, :3]).astype(np.int16)


def differing(one: Picture, other: Picture) -> float:
    """Share of the pixels that differ. A picture is cut at whole pixels, and so may have a row more."""
    height, width = (min(one.shape[k], other.shape[k]) for k in (0, 1))
    return float((np.abs(one[:height, :width] - other[:height, :width]).max(axis=2) > SAME).mean())


def changed(one: Picture, other: Picture) -> float:
    """Share of the view's small squares whose mean colour differs: a thing that is there or not, or elsewhere."""
    height, width = (min(one.shape[k], other.shape[k]) // COARSE * COARSE for k in (0, 1))
    means = [
        each[:height, :width].reshape(height // COARSE, COARSE, width // COARSE, COARSE, 3).mean(axis=(1, 3))
        for each in (one, other)
    ]
    return float((np.abs(means[0] - means[1]).max(axis=2) > ALIKE).mean())


def drawn(seen: Picture) -> float:
    """Share of the pixels that are not of the ground's colour, which is that of most."""
    colours, counts = np.unique(seen.reshape(-1, 3), axis=0, return_counts=True)
    return float((np.abs(seen - colours[counts.argmax()]).max(axis=2) > SAME).mean())
