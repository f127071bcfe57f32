"""A protected folder is refused before any work, by every command that writes."""

import os

import numpy as np
import pytest
from tiny import run

from warpfluid.files.folders import check_writable
from warpfluid.files.npz import write_npz


@pytest.fixture
def shut(tmp_path, monkeypatch):
    """A folder that is protected, also for an administrator, for whom none is."""
    (tmp_path / "shut").mkdir()
    allowed = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: "shut" not in str(path) and allowed(path, mode))
    return tmp_path / "shut"


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="an administrator may write everywhere")
def test_a_folder_without_the_right_to_write(tmp_path):
    """As the system says."""
    tmp_path.chmod(0o500)
    with pytest.raises(ValueError, match="write-protected"):
        check_writable(tmp_path)
    tmp_path.chmod(0o700)


def test_the_nearest_folder_counts(shut):
    """It is named; a file in place of a folder is another's to tell."""
    check_writable(shut.parent / "new" / "deep")
    (shut.parent / "file").touch()
    check_writable(shut.parent / "file" / "deep")
    with pytest.raises(ValueError, match="shut is write-protected: choose another folder with -o"):
        check_writable(shut / "new" / "deep")


@pytest.mark.parametrize(
    "arguments",
    [
        ("render", "A", "-o", "shut/a.png", "--frames", "1"),
        ("render", "A", "-o", "shut/new/a.###.exr"),
        ("render", "A", "-o", "shut/a.mp4"),
        ("compare", "A", "B", "-o", "shut/a.png"),
        ("compare", "A", "B", "-o", "shut/a.mp4"),
        ("export", "A", "-o", "shut/new", "--crop"),
        ("preview", "A", "--html", "shut/a.html"),
        ("preview", "A", "--screenshot", "shut/a.png"),
    ],
)
def test_commands_refuse_it_at_once(shut, arguments, monkeypatch, capsys):
    """With exit code 2, one line, and no way out that would fail again; nothing is said of any work."""
    monkeypatch.chdir(shut.parent)
    for name in "AB":
        (shut.parent / name).mkdir()
        for frame in (1, 2):
            write_npz(shut.parent / name / f"a.{frame}.npz", np.ones((32, 32, 32), np.float32))
    assert run(*arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "shut is write-protected: choose another folder with -o" in line
    assert "resume" not in line
    assert not list(shut.iterdir())
