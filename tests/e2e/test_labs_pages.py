"""One device in several labs, sign-in at a provider, webhooks, and the end of a lab, in the browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import httpx
import oidc_provider_mock
import pytest
from playwright.sync_api import expect
from tests.api.test_between_labs import evaluated, publish, results, share
from tests.e2e.conftest import running

from exogauge.settings import Settings
from exogauge.storage.store import open_installation

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page
    from tests.e2e.conftest import Service

    from exogauge.storage.store import Installation

WORDS = "three old lamps glow"
pytestmark = pytest.mark.filterwarnings("ignore:get_jwt_config:DeprecationWarning")  # of the provider, in its thread


class Behind:
    """The installation of a running service, from beside it."""

    def __init__(self, installation: Installation) -> None:
        self.installation = installation


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, browser: Browser) -> Iterator[Service]:
    folder = tmp_path_factory.mktemp("labs")
    with oidc_provider_mock.run_server_in_thread() as server:
        oidc = {
            "EXOGAUGE_OIDC_ISSUER": f"http://localhost:{server.server_port}", "EXOGAUGE_OIDC_CLIENT_ID": "exo",
            "EXOGAUGE_OIDC_CLIENT_SECRET": "secret", "EXOGAUGE_OIDC_NAME": "Uni",
        }  # fmt: skip
        ages = {"EXOGAUGE_STUDIES_KEPT_DAYS": '{"local": 365}'}
        with running(folder, workers=0, EXOGAUGE_ACCOUNTS="1", **ages, **oidc) as started:
            yield started


@pytest.fixture(scope="module")
def labs(service: Service) -> dict[str, str]:
    """name -> id: Ada founded all three."""
    base = {"base_url": f"{service.url}/api/v1", "headers": {"Origin": service.url}, "timeout": 60.0}
    with httpx.Client(**base) as ada:  # type: ignore[arg-type]
        first = {"code": (service.data / "set-up-code").read_text(), "email": "ada@example.org", "name": "Ada"}
        assert ada.post("/set-up", json={**first, "password": WORDS, "lab": "North"}).status_code == 204
        for name in ("South", "West"):
            assert ada.post("/labs", json={"name": name}).status_code == 201
        made = {lab["name"]: lab["id"] for lab in ada.get("/session").json()["labs"]}
        ada.put("/session/lab", json={"lab_id": made["North"]})
    return made


def sign_in(page: Page) -> None:
    page.goto("/sign-in")
    page.get_by_label("E-mail address").fill("ada@example.org")
    page.get_by_label("Password").first.fill(WORDS)
    page.get_by_role("button", name="Sign in", exact=True).click()
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()


def test_one_device_of_three_labs_stands_side_by_side(
    page: Page, service: Service, labs: dict[str, str], screenshot: Callable[..., None]
) -> None:
    installation = open_installation(Settings(data_dir=service.data))
    behind = Behind(installation)
    evaluated(behind, labs["North"], results(200.0, 1.0))  # type: ignore[arg-type]
    south = evaluated(behind, labs["South"], results(212.0, 2.0, robot="Large"))  # type: ignore[arg-type]
    share(behind, labs["South"], south[0], "North")  # type: ignore[arg-type]
    publish(behind, labs["West"], evaluated(behind, labs["West"], results(203.0, 4.0)))  # type: ignore[arg-type]
    installation.close()
    sign_in(page)
    page.goto("/compare")
    page.get_by_role("link", name="One device in several labs").click()
    expect(page.get_by_label("Device")).to_contain_text("Back strap, size M: 3 labs, 3 studies")
    row = page.get_by_role("row").filter(has_text="Stiffness, back")
    expect(row).to_contain_text("differ, provisional")
    expect(page.get_by_role("row").filter(has_text="Peak torque, waist in bend of large")).to_contain_text("undecided")
    worn = page.get_by_role("region", name="Who wore it: table")
    for lab, seen in (("North", "yours"), ("South", "shared with you"), ("West", "published")):
        expect(worn.get_by_role("row").filter(has_text=lab)).to_contain_text(seen)
    expect(page.get_by_role("img", name="Stiffness of back [N/m]")).to_be_visible()
    screenshot("compare-labs")


def test_an_invitation_is_taken_up_at_a_provider_and_signs_in_again(
    page: Page, browser: Browser, service: Service, labs: dict[str, str], screenshot: Callable[..., None]
) -> None:
    sign_in(page)
    page.goto("/lab")
    page.get_by_label("E-mail address").fill("bob@example.org")
    page.get_by_role("button", name="Invite", exact=True).click()
    link = page.get_by_test_id("secret").inner_text().strip()
    context = browser.new_context(base_url=service.url)
    bob = context.new_page()
    bob.goto(link)
    bob.get_by_role("button", name="Or go on with Uni").click()
    at_provider(bob, "bob-at-uni")
    expect(bob.get_by_role("heading", name="Studies", level=1)).to_be_visible()
    bob.goto("/account")
    expect(bob.get_by_text("bob-at-uni", exact=True)).to_be_visible()
    bob.get_by_role("button", name="Unlink bob-at-uni").click()
    expect(bob.get_by_role("alert")).to_contain_text("only way into the account")
    bob.context.clear_cookies()
    bob.goto("/sign-in?next=/robots")
    bob.get_by_role("button", name="Sign in with Uni").click()
    at_provider(bob, "bob-at-uni")
    expect(bob.get_by_role("heading", name="Robots", level=1)).to_be_visible()
    bob.context.clear_cookies()
    bob.goto("/sign-in")
    bob.get_by_role("button", name="Sign in with Uni").click()
    at_provider(bob, "somebody-else")
    expect(bob.get_by_role("alert")).to_contain_text("belongs to no account here")
    context.close()
    page.context.clear_cookies()
    page.goto("/sign-in?oidc=denied")
    expect(page.get_by_role("alert")).to_contain_text("not agreed")
    screenshot("sign-in-oidc")


def at_provider(page: Page, subject: str) -> None:
    page.wait_for_url("**/oauth2/authorize**")
    page.locator("input[name=sub]").first.fill(subject)
    page.locator("input[name=sub]").first.press("Enter")


def test_an_admin_sees_what_goes_by_age_and_what_to_ask_for(
    page: Page, service: Service, labs: dict[str, str], screenshot: Callable[..., None]
) -> None:
    assert labs["North"] == "local"  # the first lab is that of the settings, which the service's name by this id
    installation = open_installation(Settings(data_dir=service.data))
    evaluated(Behind(installation), labs["North"], results(205.0, 1.0))  # type: ignore[arg-type]
    installation.close()
    sign_in(page)
    page.goto("/lab")
    page.get_by_role("tab", name="What goes by age").click()
    row = page.get_by_role("row").filter(has_text="Studies, with jobs and results")
    expect(row).to_contain_text("365")
    expect(page.get_by_role("region", name="Studies that go next: table").get_by_role("link").first).to_be_visible()
    expect(page.get_by_role("row").filter(has_text="Uploaded logs")).to_contain_text("for good")
    expect(page.get_by_text("EXOGAUGE_STUDIES_KEPT_DAYS='{\"local\": 365}'")).to_be_visible()
    screenshot("what-goes-by-age")


def test_a_webhook_is_added_tried_and_removed_and_the_lab_is_closed(
    page: Page, labs: dict[str, str], screenshot: Callable[..., None]
) -> None:
    sign_in(page)
    page.goto("/lab/webhooks")
    address, add = (
        page.get_by_role("textbox", name="Address", exact=True),
        page.get_by_role("button", name="Add the webhook"),
    )
    address.fill("https://127.0.0.1:9/hook")
    page.get_by_label("something was published").check()
    add.click()
    expect(page.get_by_role("alert").filter(has_text="private")).to_be_visible()
    address.fill(
        "https://localhost:9/hook"
    )  # a name may lead elsewhere tomorrow: it is looked up when something is sent
    add.click()
    assert page.get_by_test_id("secret").inner_text().strip().startswith("whsec_")
    page.get_by_role("button", name="Done").click()
    page.get_by_role("button", name="Try it").click()
    expect(page.get_by_role("row").filter(has_text="ping")).to_contain_text("private address")
    screenshot("webhooks")
    page.get_by_role("button", name="Remove the webhook").click()
    expect(page.get_by_role("button", name="Try it")).to_have_count(0)

    page.goto("/lab")
    page.get_by_role("button", name="Close the lab").click()
    shut = page.get_by_role("button", name="Close it for everybody")
    page.get_by_label("Type its name").fill("Nort")
    expect(shut).to_be_disabled()
    page.get_by_label("Type its name").fill("North")
    shut.click()
    expect(page.get_by_role("heading", name="Account", level=1)).to_be_visible()
    expect(page.get_by_role("button", name="Account of Ada, lab South")).to_be_visible()
    expect(page.get_by_text("North (admin)")).to_have_count(0)
