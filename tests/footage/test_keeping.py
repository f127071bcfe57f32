"""Pictures are read once from the check of a shot to its inspection, if there is room for them."""

import pickle
from collections import Counter

import numpy as np
import pytest
from tiny import flame, footage

from warpfluid.files.footage import Footage
from warpfluid.footage import keeping
from warpfluid.footage.inspection import inspect_shot
from warpfluid.footage.shot import open_shot
from warpfluid.options import InputOptions

FRAMES = range(1, 5)


@pytest.fixture
def reads(monkeypatch):
    """How often each picture is read."""
    counted, read = Counter(), Footage.read

    def count(self, number):
        counted[self.source, number] += 1
        return read(self, number)

    monkeypatch.setattr(Footage, "read", count)
    return counted


@pytest.fixture
def views(tmp_path):
    """A front and a side of four frames."""
    return [f"{90 * k}={footage(tmp_path / name, FRAMES, angle=k)}" for k, name in enumerate(("front", "side"))]


@pytest.mark.parametrize("options", [InputOptions(), InputOptions(background="median", resolution="12x10")])
def test_once(reads, views, options):
    """Whatever is prepared, checked and inspected; what is found is the same."""
    found = inspect_shot(open_shot(views, options, keep=True))
    assert len(reads) == 8
    assert set(reads.values()) == {1}
    reads.clear()
    assert inspect_shot(open_shot(views, options)) == found
    assert min(reads.values()) > 1


def test_a_shot_forgets(reads, views):
    """Once it is inspected, pictures come from their files again."""
    shot = open_shot(views, keep=True)
    before = shot.views(2)
    assert reads.total() == 8
    inspect_shot(shot)
    np.testing.assert_array_equal(shot.views(2).images, before.images)
    assert reads.total() == 10


def test_room(reads, views, monkeypatch):
    """What does not fit is read again."""
    size = flame().size * 4
    monkeypatch.setattr(keeping, "free_memory", lambda: 2 * 3 * size / keeping.SHARE)
    shot = open_shot(views, keep=True)
    reads.clear()
    for frame in FRAMES:
        shot.views(frame)
    assert sorted(number for _, number in reads) == [4, 4]


def test_another_process_gets_none(reads, views):
    """It would cost more to send them."""
    shot = open_shot(views, keep=True)
    packed = pickle.dumps(shot)
    assert len(packed) < 20000
    reads.clear()
    np.testing.assert_array_equal(pickle.loads(packed).views(2).images, shot.views(2).images)
    assert reads.total() == 2


def test_which_frames():
    """A run from the middle, and samples of all."""
    frames = range(1, 1001)
    assert list(keeping.inspected(frames)) == list(range(469, 533))
    assert keeping.frames_to_keep(frames) >= {1, 1000, *range(469, 533)}
    assert len(keeping.frames_to_keep(frames)) < 90
