"""What is said where there are no volumes."""

import pytest

from warpfluid.run import SETTINGS
from warpfluid.volumes import find_volumes


def refusal(path) -> str:
    """Return the sentence that refuses a path."""
    with pytest.raises(ValueError, match="name a run") as caught:
        find_volumes(path)
    return str(caught.value)


def test_a_path_that_does_not_exist_names_the_runs_beside_it(tmp_path):
    """Those of like names first; a folder without settings is none."""
    for name in ("water", "fires", "fire-sim", "empty"):
        (tmp_path / name).mkdir()
        (tmp_path / name / SETTINGS).touch()
    (tmp_path / "empty" / SETTINGS).unlink()
    text = refusal(tmp_path / "fire")
    assert text.startswith(f"{tmp_path / 'fire'} does not exist: name a run")
    assert text.endswith("; runs beside it: fires, fire-sim, water")


def test_few_of_many_runs_are_named(tmp_path):
    """The line stays short."""
    for number in range(9):
        (tmp_path / f"fire{number}").mkdir()
        (tmp_path / f"fire{number}" / SETTINGS).touch()
    assert refusal(tmp_path / "fire").endswith("fire4, fire5 and 3 more")


def test_a_folder_that_is_there_and_one_whose_parent_is_not(tmp_path):
    """The first has no volumes; beside the second nothing can be found."""
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / SETTINGS).touch()
    assert "run has no volumes" in refusal(tmp_path / "run")
    assert "beside" not in refusal(tmp_path / "run") + refusal(tmp_path / "none" / "fire")
    assert "smoke.####.vdb has no volumes" in refusal(tmp_path / "smoke.####.vdb")
