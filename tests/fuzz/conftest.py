"""The examples' ways to make and to damage files, shared by the tests of damaged files."""

import importlib.util
import sys
from pathlib import Path

import pytest

SPEC = importlib.util.spec_from_file_location("fuzz_files", Path(__file__).parents[2] / "examples" / "fuzz_files.py")


@pytest.fixture(scope="session")
def fuzz_files():
    """The module ``examples/fuzz_files.py``."""
    module = importlib.util.module_from_spec(SPEC)
    sys.modules[SPEC.name] = module  # dataclasses look there for the types of their fields
    SPEC.loader.exec_module(module)
    return module
