"""``python -m warpfluid``."""

import sys

from warpfluid.cli import main

sys.exit(main())
