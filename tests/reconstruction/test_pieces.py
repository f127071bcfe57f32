"""Chains and pieces: which frame starts from which, whatever is there already."""

from hypothesis import given
from hypothesis import strategies as st

from warpfluid.reconstruction.pieces import FrameTask, Pieces, frame_chain


def pieces(**changes):
    return Pieces(**{"first": 1, "step": 1, "length": 4, "overlap": 2, "coherent": True} | changes)


def test_a_piece_starts_early():
    """Its first frame is led up to by frames that are not kept, which those of the piece before are drawn to."""
    known = range(1, 10)
    tasks = [pieces().task(frame, known, known) for frame in known]
    third, fourth = FrameTask(3, 2, (), (3,), 1 / 3), FrameTask(4, 3, (), (3, 4), 1 / 2)
    assert tasks[:4] == [FrameTask(1), FrameTask(2, 1), third, fourth]
    assert tasks[4:6] == [FrameTask(5, lead=(3, 4)), FrameTask(6, 5)]
    assert tasks[7:] == [FrameTask(8, 7, (), (7, 8), 1 / 2), FrameTask(9, lead=(7, 8))]
    assert pieces().chains(known) == [[1, 2, 3, 4], [5, 6, 7, 8], [9]]


@given(st.integers(0, 9))
def test_what_is_left_of_a_piece_falls_evenly(overlap):
    known = range(1, 21)
    left = 1.0
    for place, frame in enumerate(range(11 - overlap, 11), start=1):
        left *= 1 - pieces(length=10, overlap=overlap).task(frame, known, known).weight
        assert abs(left - (1 - place / (overlap + 1))) < 1e-12


def test_overlaps_longer_than_pieces():
    """A frame is drawn to the next piece alone, and may begin a piece itself."""
    known = range(1, 8)
    cut = pieces(length=2, overlap=3)
    assert cut.task(3, known, known) == FrameTask(3, lead=(1, 2), towards=(2, 3), weight=1 / 3)
    assert cut.task(5, known, known) == FrameTask(5, lead=(2, 3, 4), towards=(4, 5), weight=1 / 3)


def test_nothing_is_drawn_where_nothing_is_carried():
    """A frame that starts anew, the last piece, and one behind which too many frames lack."""
    assert pieces().task(4, range(1, 9), (1,)) == FrameTask(4)
    assert pieces().task(4, range(1, 5), range(1, 5)) == FrameTask(4, 3)
    assert pieces().task(4, (1, 2, 3, 4, 7, 8), range(1, 9)) == FrameTask(4, 3)
    assert pieces(overlap=0).task(4, range(1, 9), range(1, 9)) == FrameTask(4, 3)


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


def test_chains_are_parted_where_nothing_is_carried():
    """Frames on fours do not wait for each other; frames on twos do."""
    assert pieces(length=None).chains((1, 5, 9)) == [[1], [5], [9]]
    assert pieces(length=None).chains((1, 2, 4, 7, 8)) == [[1, 2, 4], [7, 8]]
    assert pieces(length=None, step=2).chains((1, 5, 9)) == [[1, 5, 9]]


def test_a_frame_that_failed():
    """The next one starts anew."""
    assert pieces().task(3, range(1, 9), (1,)) == FrameTask(3)


class Folder:
    """A run without volumes: what a frame would hold is told by what it was made from."""

    def __init__(self, cut, known):
        self.cut, self.known, self.records, self.made = cut, known, {}, []

    def go_on(self, wanted, fails=(), most=1000):
        """Make what lacks; some frames fail, and the run may be broken off."""
        known = sorted({*wanted, *self.records})
        expected, self.made, held = self.cut.to_make(wanted, known, self.records), [], dict(self.records)
        for group in self.cut.chains(known):
            chain = frame_chain(self.cut, group, wanted, known, held, self.forget)
            task = next(chain, None)
            while task:
                if len(self.made) == most:
                    return None
                self.made.append(task.frame)
                outcome = {"error": "it failed"} if task.frame in fails else self.outcome(task)
                if "error" not in outcome:
                    self.records[task.frame] = outcome
                try:
                    task = chain.send(outcome)
                except StopIteration:
                    task = None
        return expected

    def outcome(self, task):
        origin = self.records[task.before]["volume"] if task.before is not None else None
        volume = f"{task.frame} after {task.lead} or ({origin}), {task.weight:.3f} of {task.towards}"
        return {**task.to_dict(), "origin": origin, "volume": volume}

    def forget(self, frames):
        for frame in frames:
            del self.records[frame]


NUMBERS = st.sets(st.integers(1, 24), min_size=1)


@given(NUMBERS, st.integers(1, 9), st.integers(0, 5), st.data())
def test_whatever_happened_the_end_is_the_same(frames, length, overlap, data):
    """Parts of the frames, frames that fail, damage, and breaks at any moment: in the end all are as made in one go."""
    cut = pieces(length=data.draw(st.sampled_from([length, None])), overlap=overlap)
    whole, broken = Folder(cut, frames), Folder(cut, frames)
    assert whole.go_on(frames) == sorted(frames) == whole.made
    some = st.sets(st.sampled_from(sorted(frames)), min_size=1)
    for _ in range(data.draw(st.integers(0, 4))):
        broken.go_on(data.draw(some), data.draw(some), data.draw(st.integers(0, 30)))
        broken.forget(data.draw(some) & broken.records.keys())
    expected = broken.go_on(frames)
    assert broken.records == whole.records
    assert set(expected) <= set(broken.made)
    assert broken.go_on(frames) == []


@given(NUMBERS, st.integers(1, 9), st.data())
def test_a_frame_that_fails_again_changes_nothing(frames, length, data):
    """Those behind it started anew, and are not made once more before it is there."""
    run = Folder(pieces(length=length), frames)
    fails = data.draw(st.sets(st.sampled_from(sorted(frames))))
    run.go_on(frames, fails)
    before = dict(run.records)
    run.go_on(frames, fails)
    assert set(run.made) == fails
    assert run.records == before


def test_a_lead_that_was_another():
    """A frame that came into the middle of a lead is noticed, though the last of them is the same."""
    run = Folder(pieces(overlap=3), range(1, 7))
    run.go_on([1, 2, 4, 5, 6])
    assert run.records[5]["lead"] == [1, 2, 4]
    run.go_on(range(1, 7))
    assert run.records[5]["lead"] == [2, 3, 4]


def test_a_run_that_began_before_starts_were_noted():
    """Its frames stay, and others go on from them."""
    run = Folder(pieces(length=None), range(1, 7))
    run.go_on(range(1, 5))
    run.records = {frame: {"energies": []} for frame in run.records}
    run.outcome = lambda task: {**task.to_dict(), "origin": "of the file", "volume": "new"}
    run.go_on(range(1, 6))
    assert run.made == [5]
    run.go_on(range(1, 6))
    assert run.made == []


def test_a_shot_that_grows():
    """What ended it is drawn to the piece that came, and nothing else is made again."""
    run = Folder(pieces(), range(1, 9))
    run.go_on(range(1, 5))
    run.go_on(range(1, 9))
    assert run.made == [3, 4, 5, 6, 7, 8]


def test_frames_that_are_not_asked_for():
    """They stay until they are, and are then made as in one go."""
    run, whole = Folder(pieces(length=None), range(1, 7)), Folder(pieces(length=None), range(1, 7))
    run.go_on(range(1, 7), fails=[3])
    run.go_on(range(1, 5))
    assert run.made == [3, 4]
    assert sorted(run.records) == [1, 2, 3, 4, 5, 6]
    run.go_on(range(1, 7))
    whole.go_on(range(1, 7))
    assert run.made == [5, 6]
    assert run.records == whole.records
