"""The bodies of a run, from its settings and its file."""

import numpy as np
import pytest

from warpfluid.files.bodies import write_bodies
from warpfluid.run import BODIES
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.recorded import RecordedBodies

SHAPE = (20, 24, 30)
SETTINGS = {"body": [{"size": "2,1,1", "center": "1,2,0"}, {"size": "1,1,1"}]}


def record(folder, count):
    still = dict.fromkeys(("velocity", "spin"), np.zeros(3)) | {"quaternion": np.array([0.0, 0, 0, 1])}
    states = [still | {"position": np.array([7.0, 8, 9 + i])} for i in range(count)]
    origin = Placing(SHAPE, 1.0).origin
    write_bodies(folder / BODIES, [f"body{i}" for i in range(count)], {2: states}, voxel=0.5, origin=origin)


def test_settings_say_what_and_the_file_says_where(tmp_path):
    """In voxels as they start, in scene units as they are recorded."""
    record(tmp_path, 2)
    bodies, origin = RecordedBodies(SETTINGS, tmp_path), Placing(SHAPE, 1.0).origin
    assert bodies.names == ["body0", "body1"]
    one, other = bodies.place(SHAPE, 1)
    np.testing.assert_allclose(one.position, origin + np.array([3, 6, 0]))
    np.testing.assert_allclose(np.ptp(one.vertices, axis=0), [6, 3, 3], rtol=1e-6)
    np.testing.assert_allclose(np.ptp(other.vertices, axis=0), [3, 3, 3], rtol=1e-6)
    np.testing.assert_allclose(bodies.states[2][1]["position"], 0.5 * ([7, 8, 10] - origin))


def test_no_file_and_no_bodies(tmp_path):
    """A run that has not begun has no file; a file without bodies in the settings is not read."""
    assert RecordedBodies(SETTINGS, tmp_path).states == {}
    (tmp_path / BODIES).write_text("damaged")
    assert RecordedBodies({}, tmp_path).names == []


def test_what_does_not_fit(tmp_path):
    """Other bodies than the settings have, and settings that no body has."""
    record(tmp_path, 1)
    with pytest.raises(ValueError, match=r"bodies.json has 1 bodies, the settings 2"):
        _ = RecordedBodies(SETTINGS, tmp_path).names
    with pytest.raises(ValueError, match=r"run.toml: \[\[body\]\] 'wieght' is unknown"):
        RecordedBodies({"body": [{"wieght": 1.0}]}, tmp_path)
