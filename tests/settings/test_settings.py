"""Settings: flags over the paper's choices over a file over the defaults."""

import dataclasses
import tomllib

import pytest
import tomli_w

from warpfluid.options import EmitterOptions, ReconstructOptions
from warpfluid.settings import make_settings, make_simulate_settings, read_settings


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
    made = make_settings(["0=a"], None, Flags(**flags), None, paper=paper, document=read_settings(tmp_path / "c.toml"))
    assert {name: getattr(made.reconstruct, name) for name in expected} == expected


def test_views_of_the_file_unless_given(tmp_path):
    """A file may name the views; flags replace all of them."""
    (tmp_path / "c.toml").write_text('views = ["0=a", "90=b"]')
    assert make_settings([], None, None, None, document=read_settings(tmp_path / "c.toml")).views == ("0=a", "90=b")
    assert make_settings(["0=c"], None, None, None, document=read_settings(tmp_path / "c.toml")).views == ("0=c",)


def test_documents_come_back(tmp_path, monkeypatch):
    """What is written to TOML makes the same settings, with whole paths and every digit of an angle."""
    monkeypatch.chdir(tmp_path)
    made = make_settings(["33.333333333=a", "-90=/b/../c"], None, Flags(blur=0.1), None)
    document = tomllib.loads(tomli_w.dumps(made.to_dict()))
    assert document["views"] == [f"33.333333333={tmp_path / 'a'}", "-90=/c"]
    (tmp_path / "run.toml").write_text(tomli_w.dumps(document))
    again = make_settings([], None, None, None, document=read_settings(tmp_path / "run.toml"))
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


@dataclasses.dataclass
class SimulateFlags:
    """Flags of simulate; None was not given."""

    swirl: float | None = None
    blend: float | None = None


@dataclasses.dataclass
class LookFlags:
    """A flag of the output."""

    look: str | None = None


def simulate(source=None, config=None, lines=(), output=None, **more):
    """Return settings of a simulation; ``lines`` are those of emitters."""
    flags = {name: more.pop(name) for name in ("swirl", "blend") if name in more}
    method = SimulateFlags(**flags) if flags else None
    things = {"emitter": list(lines), "obstacle": None, "force": None, "body": None}
    document = read_settings(config) if config else None
    return make_simulate_settings(source, method, output, things, document=document, **more)


@pytest.mark.parametrize(
    ("given", "file", "expected"),
    [
        ({}, {}, {"swirl": 0.0, "blend": 0.5}),
        ({}, {"swirl": 1.0}, {"swirl": 1.0}),
        ({"preset": "smoke"}, {"swirl": 1.0, "blend": 0.3}, {"swirl": 4.0, "blend": 0.3}),
        ({"preset": "smoke", "swirl": 2.0}, {"swirl": 1.0}, {"swirl": 2.0}),
        ({"paper": True}, {"blend": 0.9}, {"blend": 0.2, "order": "blend-first"}),
        ({"paper": True, "blend": 0.7}, {"blend": 0.9}, {"blend": 0.7, "subtract": 0.0}),
    ],
)
def test_order_of_a_simulation(tmp_path, monkeypatch, given, file, expected):
    """Flags over the preset and the paper's choices over a file over the defaults."""
    monkeypatch.setattr(
        "warpfluid.settings.of_simulation.preset_settings", lambda _, first: {"simulate": {"swirl": 4.0}}
    )
    (tmp_path / "c.toml").write_text(tomli_w.dumps({"simulate": file}))
    made = simulate("a", tmp_path / "c.toml", **given)
    assert {name: getattr(made.simulate, name) for name in expected} == expected


def test_a_preset_counts_more_than_the_paper(tmp_path):
    """Where both name a number; all else of the paper stays."""
    (tmp_path / "c.toml").write_text("[simulate]\ndensity_dissipation = 3.0\nblend = 0.9")
    made = simulate("a", tmp_path / "c.toml", preset="smoke", paper=True).simulate
    assert made.density_dissipation == 0.08
    assert (made.order, made.blend) == ("blend-first", 0.2)


def test_the_source_decides_how_files_are_stored(tmp_path):
    """Unless a file or a flag says otherwise."""
    (tmp_path / "c.toml").write_text('[output]\nup = "y"')
    stored = {"up": "z", "half": True, "look": "gray"}
    assert simulate("a", source_output=stored).output.up == "z"
    made = simulate("a", tmp_path / "c.toml", source_output=stored, output=LookFlags(look="jet")).output
    assert (made.up, made.half, made.look) == ("y", True, "jet")


def test_things_add_up(tmp_path):
    """Of the file, of the preset where there is no source, and of the command line; none is put in twice."""
    one, two = EmitterOptions(density=1.0), EmitterOptions(shape="box", density=2.0)
    (tmp_path / "c.toml").write_text('[[emitter]]\ndensity = 1\n[[obstacle]]\nshape = "box"')
    lines = ["sphere density=1", "box density=2"]
    assert simulate("a", lines=lines).scene.emitter == (one, two)
    assert simulate("a", tmp_path / "c.toml", lines=lines).scene.emitter == (one, two)
    assert simulate("a", tmp_path / "c.toml").scene.obstacle[0].shape == "box"
    assert len(simulate(None, preset="smoke", lines=lines).scene.emitter) == 3
    assert len(simulate("a", preset="smoke", lines=lines).scene.emitter) == 2


def test_documents_of_simulations_come_back(tmp_path, monkeypatch):
    """What is written to TOML makes the same settings, with whole paths."""
    monkeypatch.chdir(tmp_path)
    for source, size in (("run", None), (None, (16, 24))):
        made = simulate(source, lines=["mesh mesh=a.obj center='1:0,1,0;9:0,2,0'"], swirl=1.0, size=size)
        (tmp_path / "run.toml").write_text(tomli_w.dumps(made.to_dict()))
        again = simulate(None, tmp_path / "run.toml")
        assert again.to_dict() == made.to_dict()
        assert again.scene.emitter[0].mesh == str(tmp_path / "a.obj")
        assert (again.source, again.size) == ((str(tmp_path / "run"), None) if source else (None, (16, 24)))


def test_everything_wrong_in_a_file_of_a_simulation(tmp_path):
    """A line each, with what is expected."""
    (tmp_path / "c.toml").write_text(
        "source = 3\nsize = [1]\n[simulate]\nswirll = 1\nblend = 2\n[[emitter]]\nfuel = -1\n[[body]]\ncolour = 1\n"
        "[force]"
    )
    with pytest.raises(ValueError, match=r".") as error:
        read_settings(tmp_path / "c.toml")
    found = "\n".join(line.removeprefix(f"{tmp_path / 'c.toml'}: ") for line in str(error.value).splitlines())
    for words in (
        "source is 3, expected the path of a run or of volumes",
        "size is [1], expected a width and a height such as [96, 144]",
        "[simulate] has no option 'swirll'; did you mean swirl?",
        "[simulate] blend is 2, expected 0 to 1",
        "[[emitter]] fuel is -1, expected 0 to 1000000",
        "[[body]] 'colour' is unknown; expected are shape, center",
        "force is {}, expected tables [[force]]",
    ):
        assert words in found
    assert len(found.splitlines()) == 7
