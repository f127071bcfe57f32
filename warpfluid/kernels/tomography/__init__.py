"""Rays, the visual hull, and the steps of tomography."""
