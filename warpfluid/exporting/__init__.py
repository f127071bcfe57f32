"""Volumes for other programs: what ``warpfluid export`` is made of."""
