"""What a file is, in words and numbers: ``warpfluid inspect FILE``."""

from warpfluid.explaining.files import explain

__all__ = ["explain"]
