import os
import platform
import subprocess
import sys

import pytest

HELD_BELOW_THE_LAST = """
import os
import numpy as np
from exogauge.resident import give_back

def resident():
    return int(open("/proc/self/statm").read().split()[1]) * os.sysconf("SC_PAGESIZE") / 1e6

blocks = [np.ones(8000) for _ in range(3000)]  # 64 kB each, from the heap
last = blocks.pop()
del blocks
before = resident()
give_back()
print(before - resident())
"""


@pytest.mark.slow
@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
def test_what_was_freed_below_what_is_still_used_goes_back_to_the_system():
    told = subprocess.run([sys.executable, "-c", HELD_BELOW_THE_LAST], capture_output=True, text=True, check=True,
                          env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})  # fmt: skip
    assert float(told.stdout) > 150.0, told.stdout
