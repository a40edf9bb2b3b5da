"""The robot in 3D beside the plots: it is drawn, it stands where the cursor is, and the cursor goes where it plays."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest
from playwright.sync_api import expect
from tests.e2e.robot_in_3d import (
    TRIES,
    changed,
    differing,
    drawn,
    is_again,
    listen,
    picture,
    said,
    stopped_at,
    wait_until_drawn,
)
from tests.e2e.test_review import LOG, time_axis

if TYPE_CHECKING:
    from playwright.sync_api import Page

TITLE = "Supporting torque at torso_pitch"
SAMPLE_S = 1 / 200
STANDS_AT = """([wanted, most]) => {
  const told = window.heard.filter(({type}) => type === "time").at(-1);
  return told !== undefined && Math.abs(told.time - wanted) <= most;
}"""

KEPT_IN_ADDRESS = """([wanted, most]) =>
  Math.abs(Number(new URLSearchParams(location.search).get("at")) - wanted) <= most"""


@pytest.fixture
def robot(page: Page, study: dict[str, Any]) -> Page:
    """The page of the plots with the robot of a bend beside them."""
    listen(page)
    page.emulate_media(reduced_motion="reduce")
    page.goto(f"{study['path']}/plots?log={LOG}&show=support.torso_pitch&show=tension&robot=yes&at=0")
    wait_until_drawn(page)
    expect(page.locator(".u-over")).to_have_count(2)
    return page


def hover(page: Page, share: float) -> float:
    """Move the pointer over the last plot; the time [s] there, as the plot's axis has it, once the robot is there."""
    over = page.locator(".u-over").last
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + share * box["width"], box["y"] + box["height"] / 2)
    axis = time_axis(page, TITLE)
    low, high = (float(axis.get_attribute(f"aria-value{end}") or "nan") for end in ("min", "max"))
    wanted = low + share * (high - low)
    if page.locator("iframe").count():
        page.wait_for_function(STANDS_AT, arg=[wanted, 0.05])
    return wanted


def shown_time(page: Page) -> float:
    """What the 3D view's own clock says [s]."""
    found = re.search(r"([\d.]+) / [\d.]+ s", page.get_by_role("region", name="3D view of").inner_text())
    assert found is not None
    return float(found.group(1))


def read_at(page: Page) -> list[float]:
    """The times [s] at which the tables beside the plots read."""
    captions = page.locator("caption").filter(has_text=re.compile(r"At \d")).all_inner_texts()
    digits = [re.sub(r"[^\d.]", "", text) for text in captions]
    return [float(each) for each in digits if each]  # one may have changed since it was found


def wait_until_read_at(page: Page, wanted: float) -> None:
    """Until the view's clock and the tables beside both plots tell that time [s]: tables follow a cursor that rests."""
    for _ in range(TRIES):
        told = [shown_time(page), *read_at(page)]
        if told == pytest.approx([wanted] * 3, abs=0.05):
            return
        page.wait_for_timeout(250)
    raise AssertionError(f"at {wanted} s the clock and the tables tell {told}")


def test_it_is_drawn_and_stands_where_the_cursor_is(robot: Page) -> None:
    hover(robot, 0.02)
    upright = picture(robot)
    assert drawn(upright) > 0.03
    wanted = hover(robot, 0.5)
    bent = picture(robot)
    wait_until_read_at(robot, wanted)
    assert changed(upright, bent) > 0.01
    hover(robot, 0.02)
    assert is_again(robot, upright)


def test_keys_in_a_plot_move_it_too(robot: Page) -> None:
    hover(robot, 0.02)
    upright = picture(robot)
    axis = time_axis(robot, TITLE)
    axis.focus()
    axis.press("End")
    end = float(axis.get_attribute("aria-valuemax") or "nan")
    expect(robot.get_by_role("region", name="3D view of")).to_contain_text(f"{end:.2f} / ")
    robot.wait_for_function(STANDS_AT, arg=[end, 0.05])
    assert differing(upright, picture(robot)) > 0.0


def test_while_it_plays_the_cursor_of_every_plot_goes_along(robot: Page) -> None:
    start = hover(robot, 0.1)
    robot.get_by_label("Speed").select_option("0.1")
    robot.get_by_role("button", name="Play").click()
    robot.wait_for_function(
        "(start) => window.heard.some(({type, time}) => type === 'time' && time > start + 0.2)", arg=start
    )
    robot.get_by_role("button", name="Pause").click()
    expect(robot.get_by_role("button", name="Play")).to_be_visible()
    stood = stopped_at(robot)
    assert stood > start + 0.2
    wait_until_read_at(robot, stood)
    robot.wait_for_function(KEPT_IN_ADDRESS, arg=[stood, 0.05])


def test_the_joint_where_the_model_lacked_something_is_marked(
    robot: Page,
    study: dict[str, Any],
    screenshot: Callable[..., None],
) -> None:
    (finding,) = study["results"]["discrepancy"]["findings"]
    marked = said(robot, "loaded")["about"]["marked"]
    assert [each["joint"] for each in marked] == [finding["where"]["joint"]]
    assert "stribeck" in marked[0]["effect"].lower()
    marks = robot.get_by_label("joints that the model does not explain")
    expect(marks).to_be_checked()
    marks.uncheck()
    without = picture(robot)
    marks.check()
    assert 0.001 < changed(without, picture(robot)) < 0.2
    marks.uncheck()
    assert is_again(robot, without)
    marks.check()
    screenshot("review-3d", without=("iframe",))
