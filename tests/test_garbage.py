import gc
import importlib
from contextlib import AbstractContextManager, nullcontext

import pytest

from exogauge.garbage import left_while_loading


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
