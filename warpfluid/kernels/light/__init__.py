"""Light through a medium: marched rays, shadows, lamps, surfaces."""
