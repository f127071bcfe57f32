"""Everything that runs on the device: Warp kernels and their launchers, one operation a file."""
