"""Settings: flags over the paper's choices over a file over the defaults."""

import dataclasses
import tomllib

import pytest
import tomli_w

from warpfluid.options import ReconstructOptions
from warpfluid.settings import make_settings, read_settings


@dataclasses.dataclass
class Flags:
    """Flags of a command line; None was not given."""

    blur: float | None = None
    iterations: int | None = None


@pytest.mark.parametrize(
    ("flags", "paper", "file", "expected"),
    [
        ({}, False, {}, {"blur": 0.4, "fade": 0.5}),
        ({}, False, {"blur": 2.0}, {"blur": 2.0, "fade": 0.5}),
        ({"blur": 3.0}, False, {"blur": 2.0, "iterations": 5}, {"blur": 3.0, "iterations": 5}),
        ({}, True, {"fade": 0.2, "blur": 2.0}, {"fade": 0.0, "blur": 2.0}),
        ({"blur": 3.0}, True, {"preconditioner": "ramp"}, {"blur": 3.0, "preconditioner": "none"}),
    ],
)
def test_order(tmp_path, flags, paper, file, expected):
    """Each source wins over the ones below it, option by option."""
    (tmp_path / "c.toml").write_text(tomli_w.dumps({"reconstruct": file}))
    made = make_settings(["0=a"], None, Flags(**flags), None, paper=paper, config=tmp_path / "c.toml")
    assert {name: getattr(made.reconstruct, name) for name in expected} == expected


def test_views_of_the_file_unless_given(tmp_path):
    """A file may name the views; flags replace all of them."""
    (tmp_path / "c.toml").write_text('views = ["0=a", "90=b"]')
    assert make_settings([], None, None, None, config=tmp_path / "c.toml").views == ("0=a", "90=b")
    assert make_settings(["0=c"], None, None, None, config=tmp_path / "c.toml").views == ("0=c",)


def test_documents_come_back(tmp_path, monkeypatch):
    """What is written to TOML makes the same settings, with whole paths and every digit of an angle."""
    monkeypatch.chdir(tmp_path)
    made = make_settings(["33.333333333=a", "-90=/b/../c"], None, Flags(blur=0.1), None)
    document = tomllib.loads(tomli_w.dumps(made.to_dict()))
    assert document["views"] == [f"33.333333333={tmp_path / 'a'}", "-90=/c"]
    (tmp_path / "run.toml").write_text(tomli_w.dumps(document))
    again = make_settings([], None, None, None, config=tmp_path / "run.toml")
    assert again.reconstruct == made.reconstruct == ReconstructOptions(blur=0.1)
    assert again.to_dict() == made.to_dict()


def test_everything_wrong_in_a_file(tmp_path):
    """One error with a line for each mistake."""
    (tmp_path / "c.toml").write_text('colour = 1\n[input]\nwite = 3\nframes = 1\n[output]\nup = "x"')
    with pytest.raises(ValueError, match=r".") as error:
        read_settings(tmp_path / "c.toml")
    lines = str(error.value).splitlines()
    assert len(lines) == 4
    assert all(line.startswith(f"{tmp_path / 'c.toml'}: ") for line in lines)
    assert any("did you mean white?" in line for line in lines)
