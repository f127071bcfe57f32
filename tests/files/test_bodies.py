"""Bodies there and back, in scene units; nothing half-written, nothing that is not a number."""

import json

import numpy as np
import pytest

from warpfluid.files.bodies import read_bodies, write_bodies


def some_body(seed):
    rng = np.random.default_rng(seed)
    lengths = {"position": 3, "quaternion": 4, "velocity": 3, "spin": 3, "rest": 2}
    return {name: rng.standard_normal(n) for name, n in lengths.items()}


def test_there_and_back(tmp_path):
    """Positions around the scene's origin, lengths in its unit, the rest as it is."""
    frames = {7: [some_body(0), some_body(1)], 3: [some_body(2), some_body(3)]}
    write_bodies(tmp_path / "bodies.json", ["car", "lid"], frames, voxel=0.25, origin=(10, -0.5, 20))
    names, read = read_bodies(tmp_path / "bodies.json")
    assert names == ["car", "lid"]
    assert list(read) == [3, 7]
    for frame, bodies in frames.items():
        for body, back in zip(bodies, read[frame], strict=True):
            np.testing.assert_allclose(back["position"], 0.25 * (body["position"] - [10, -0.5, 20]), rtol=1e-14)
            np.testing.assert_allclose(back["velocity"], 0.25 * body["velocity"], rtol=1e-14)
            for name in ("quaternion", "spin"):
                np.testing.assert_array_equal(back[name], body[name])
            assert "rest" not in back


def test_is_plain_json(tmp_path):
    """That other tools read."""
    write_bodies(tmp_path / "bodies.json", ["car"], {1: [some_body(0)]}, voxel=1, origin=(0, 0, 0))
    content = json.loads((tmp_path / "bodies.json").read_text())
    assert content["frames"][0]["frame"] == 1
    assert len(content["frames"][0]["bodies"][0]["quaternion"]) == 4


def test_refuses_what_does_not_fit(tmp_path):
    """And leaves no file."""
    broken = some_body(0) | {"velocity": np.array([0, np.nan, 0])}
    for names, frames, words in [(["car"], {4: [broken]}, "frame 4"), (["car", "lid"], {2: [some_body(0)]}, "2 names")]:
        with pytest.raises(ValueError, match=words):
            write_bodies(tmp_path / "bodies.json", names, frames, voxel=1, origin=(0, 0, 0))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("content", ["", "{}", "[1]", '{"names": ["a"], "frames": [{"frame": 1, "bodies": []}]}'])
def test_refuses_other_files(content, tmp_path):
    """In words."""
    (tmp_path / "bodies.json").write_text(content)
    with pytest.raises(ValueError, match="no file of bodies"):
        read_bodies(tmp_path / "bodies.json")
