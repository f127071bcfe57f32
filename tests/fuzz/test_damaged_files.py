"""Damaged files of every kind that is read: success, or one error of ours that names the file."""

import random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

# Files tried by kind; examples/fuzz.py tries as many as there is time for.
COUNTS = {
    "vdb": 60,
    "blosc": 150,
    "nvdb": 60,
    "npz": 150,
    "vti": 100,
    "exr": 100,
    "hdr": 150,
    "image": 150,
    "video": 50,
    "mesh": 60,
    "table": 150,
}


def test_every_kind_is_tried(fuzz_files):
    """A new kind gets its number."""
    assert set(COUNTS) == set(fuzz_files.KINDS)


@pytest.mark.parametrize("kind", COUNTS)
def test_sound_files_are_read(fuzz_files, tmp_path, kind):
    """What is damaged later is no error before."""
    for number, (ending, data) in enumerate(fuzz_files.KINDS[kind].make()):
        path = tmp_path / f"a.{number}{ending}"
        path.write_bytes(data)
        fuzz_files.KINDS[kind].read(path)
        path.unlink()


@pytest.mark.parametrize("kind", COUNTS)
def test_damaged_files_end_in_an_error_of_ours(fuzz_files, tmp_path, capfd, kind):
    """It names the file, and nothing is printed by any library; a warning would be an error here."""
    sound = fuzz_files.KINDS[kind].make()

    @settings(max_examples=COUNTS[kind], suppress_health_check=list(HealthCheck))
    @given(which=st.integers(0, len(sound) - 1), seed=st.integers(0, 2**32))
    def try_one(which, seed):
        ending, data = sound[which]
        path = tmp_path / f"damaged.0007{ending}"
        path.write_bytes(fuzz_files.KINDS[kind].harm(data, random.Random(seed)))
        error = None
        try:
            fuzz_files.KINDS[kind].read(path)
        except (ValueError, OSError) as found:
            error = found
        assert error is None or path.name in str(error)

    try_one()
    assert capfd.readouterr() == ("", "")
