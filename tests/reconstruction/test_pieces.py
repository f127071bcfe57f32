"""Chains and pieces: which frame starts from which, whatever is there already."""

from hypothesis import given
from hypothesis import strategies as st

from warpfluid.reconstruction.pieces import FrameTask, Pieces, frame_chain


def pieces(**changes):
    return Pieces(**{"first": 1, "step": 1, "length": 4, "overlap": 2, "coherent": True} | changes)


def test_a_piece_starts_early():
    """Its first frame is led up to by frames that are dropped; the others follow it."""
    known = range(1, 10)
    tasks = [pieces().task(frame, known, known) for frame in known]
    assert tasks[:4] == [FrameTask(1), FrameTask(2, 1), FrameTask(3, 2), FrameTask(4, 3)]
    assert tasks[4:6] == [FrameTask(5, lead=(3, 4)), FrameTask(6, 5)]
    assert pieces().chains(known) == [[1, 2, 3, 4], [5, 6, 7, 8], [9]]


def test_one_piece():
    assert pieces(length=None).chains(range(1, 9)) == [list(range(1, 9))]
    assert pieces(length=None).task(5, range(1, 9), range(1, 5)) == FrameTask(5, 4)


def test_frames_alone():
    assert pieces(coherent=False).chains([3, 1]) == [[1], [3]]
    assert pieces(coherent=False).task(5, range(1, 9), range(1, 5)) == FrameTask(5)


def test_gaps():
    """A frame is carried over one that is left out, not over two; nor does a lead reach across."""
    known = (1, 2, 4, 7, 8, 9)
    assert pieces(length=None).task(4, known, known) == FrameTask(4, 2)
    assert pieces(length=None).task(7, known, known) == FrameTask(7)
    assert pieces(overlap=9).task(9, known, known) == FrameTask(9, lead=(7, 8))
    assert pieces(step=2, first=1).task(9, (1, 3, 5, 7, 9), ()) == FrameTask(9, lead=(5, 7))


def test_a_frame_that_failed():
    """The next one starts anew."""
    assert pieces().task(3, range(1, 9), (1,)) == FrameTask(3)


@given(st.sets(st.integers(1, 40), min_size=1), st.integers(1, 9), st.integers(0, 5), st.data())
def test_what_is_there_changes_nothing(frames, length, overlap, data):
    """However many frames are done already, each of the others is made as in one go."""
    cut, frames = pieces(length=length, overlap=overlap), sorted(frames)

    def made(wanted, done):
        found = {}
        for group in cut.chains(wanted):
            chain = frame_chain(cut, group, set(frames), done)
            task = next(chain, None)
            while task:
                found[task.frame] = task
                try:
                    task = chain.send({})
                except StopIteration:
                    task = None
        return found

    done = data.draw(st.sets(st.sampled_from(frames)))
    whole = made(frames, set())
    assert sorted(whole) == frames
    rest = made([frame for frame in frames if frame not in done], set(done))
    assert all(rest[frame] == whole[frame] for frame in rest)
