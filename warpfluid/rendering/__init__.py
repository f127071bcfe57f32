"""From volumes to pictures: colour ramps, turntables, slices."""
