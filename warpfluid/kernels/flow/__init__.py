"""Optical flow between pictures, and lifted into volumes."""
