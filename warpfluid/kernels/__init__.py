"""Everything that runs on the device: Warp kernels and their launchers, one operation a file."""

import warp as wp

wp.config.log_level = wp.LOG_WARNING  # the banner would go to stdout, in the middle of --json
