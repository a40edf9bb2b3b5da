"""BLAS beside other threads: the bits of SciPy's wrapper, and an interpreter that is free meanwhile."""

import threading
import time

import numpy as np
import pytest
import scipy.linalg as sl

from exogauge.estimation.statistics import add_gram

LAYOUTS = {
    "by columns": np.asfortranarray,
    "by rows": np.ascontiguousarray,
    "part of one by columns": lambda x: np.asfortranarray(np.vstack([x, x, x]))[len(x) : 2 * len(x)],
    "part of one by rows": lambda x: np.ascontiguousarray(np.hstack([x, x]))[:, : x.shape[1]],
    "every other row": lambda x: np.repeat(x, 2, axis=0)[::2],
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("shape", [(1, 1), (0, 3), (3, 0), (7, 3), (203, 41), (1000, 12)])
def test_it_is_what_scipy_computes_to_the_last_bit(layout, shape):
    rng = np.random.default_rng(0)
    block, begun = rng.normal(size=shape), np.triu(rng.normal(size=(shape[1],) * 2))
    gram = np.array(begun, order="F")
    add_gram(LAYOUTS[layout](block), gram)
    expected = begun
    if 0 not in shape:
        by_rows = LAYOUTS[layout](block).flags.c_contiguous
        given = np.ascontiguousarray(block).T if by_rows else np.asfortranarray(block)
        expected = sl.blas.dsyrk(1.0, given, beta=1.0, c=np.asfortranarray(begun), trans=not by_rows)
    np.testing.assert_array_equal(gram, expected)
    np.testing.assert_allclose(np.triu(gram), np.triu(begun + block.T @ block), rtol=1e-12, atol=1e-12)


def test_another_shape_or_layout_is_refused():
    with pytest.raises(ValueError, match="by columns"):
        add_gram(np.zeros((5, 3)), np.zeros((4, 4), order="F"))
    with pytest.raises(ValueError, match="by columns"):
        add_gram(np.zeros((5, 3)), np.zeros((3, 3), order="C"))


@pytest.mark.slow
def test_the_interpreter_is_free_while_it_computes():
    block, gram = np.ones((60_000, 300), order="F"), np.zeros((300, 300), order="F")
    began, ended, looks = threading.Event(), threading.Event(), 0

    def work():
        began.set()
        for _ in range(5):
            add_gram(block, gram)
        ended.set()

    thread = threading.Thread(target=work)
    thread.start()
    began.wait()
    while not ended.is_set():
        time.sleep(0.001)
        looks += 1
    thread.join()
    assert looks > 20  # with the interpreter held, one look for each of the five
    assert gram[0, 0] == 5 * len(block)
