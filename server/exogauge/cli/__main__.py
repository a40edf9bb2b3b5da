"""`python -m exogauge.cli`."""

import sys

from exogauge.cli import main

sys.exit(main())
