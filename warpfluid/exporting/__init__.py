"""Volumes for other programs: what ``warpfluid export`` does."""

from warpfluid.exporting.command import export

__all__ = ["export"]
