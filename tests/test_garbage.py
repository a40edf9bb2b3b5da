import gc
import importlib
import weakref
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

import pytest

from exogauge.garbage import left_while_loading
from exogauge.jobs.child import resolve


def loading(module: str) -> None:
    with left_while_loading():
        with left_while_loading():
            assert not gc.isenabled()
        assert not gc.isenabled()
        importlib.import_module(module)


@pytest.mark.parametrize(
    ("module", "raises"), [("json", nullcontext()), ("no_such_module", pytest.raises(ImportError))]
)
def test_garbage_is_left_while_modules_load_and_looked_for_after_it(
    module: str, raises: AbstractContextManager
) -> None:
    gc.unfreeze()
    with raises:
        loading(module)
    assert gc.isenabled()
    assert gc.get_freeze_count() > 0


class Ring:
    """Which only a look for garbage finds."""

    def __init__(self) -> None:
        self.itself = self


@pytest.mark.parametrize("again", [lambda: loading("json"), lambda: resolve("json:dumps")])
def test_what_one_request_leaves_goes_though_the_next_loads_something(again: Callable[[], object]) -> None:
    again()
    left = weakref.ref(Ring())
    again()
    gc.collect()
    assert left() is None
