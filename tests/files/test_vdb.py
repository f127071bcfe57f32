"""Volumes survive the trip through a .vdb file, and damaged files end in an error."""

import contextlib
import os
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from warpfluid.files import limits
from warpfluid.files.vdb import lost_mass, read_vdb, write_vdb

SHAPES = [(1, 1, 1), (3, 5, 7), (8, 8, 8), (16, 8, 24), (130, 9, 10), (9, 130, 10), (5, 7, 257), (4100, 2, 3)]
ID_VERSION = 21 + 14  # the byte of the file's id that says it is a checksum
CHECK_ALL = settings(max_examples=60, deadline=None, derandomize=True)


def sparse(shape, share=0.2, seed=0):
    """Random values in blobs and single voxels, most of the volume empty."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=shape).astype(np.float32)
    return np.where(rng.random(shape) < share, values, np.float32(0))


def written(path, grids, **options):
    """Write, read and return the file."""
    write_vdb(path, grids, **options)
    return read_vdb(path)


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("shape", SHAPES)
def test_round_trip_is_exact(tmp_path, shape, up):
    """Scalars and vectors come back bit for bit, on either up axis, and as contiguous float32."""
    density, velocity = sparse(shape), np.stack([sparse(shape, seed=seed) for seed in (1, 2, 3)], axis=-1)
    grids = {"density": density, "velocity": velocity}
    file = written(tmp_path / "a.vdb", grids, up=up, origin=(-1.5, 2.25, 1e6), voxel_size=0.1)
    assert list(file.grids) == ["density", "velocity"]
    for name, array in grids.items():
        assert np.array_equal(file.grids[name], array)
        assert file.grids[name].dtype == np.float32
        assert file.grids[name].flags.c_contiguous
    assert file.voxel_size == 0.1
    assert file.origin == (-1.5, 2.25, 1e6)


@pytest.mark.parametrize("up", ["y", "z"])
def test_half_gives_back_the_nearest_halves(tmp_path, up):
    """With half=True every value is the nearest 16-bit float."""
    density, velocity = sparse((20, 9, 17)) * 100, np.stack([sparse((20, 9, 17), seed=4)] * 3, axis=-1)
    file = written(tmp_path / "a.vdb", {"density": density, "velocity": velocity}, half=True, up=up)
    assert np.array_equal(file.grids["density"], density.astype(np.float16).astype(np.float32))
    assert np.array_equal(file.grids["velocity"], velocity.astype(np.float16).astype(np.float32))


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("up", ["y", "z"])
def test_empty_and_single_voxel(tmp_path, half, up):
    """A volume without a voxel keeps its shape, and so does one with a single voxel in a corner."""
    empty = np.zeros((11, 40, 3), np.float32)
    single = empty.copy()
    single[10, 39, 2] = 5
    file = written(tmp_path / "a.vdb", {"empty": empty, "single": single}, half=half, up=up)
    assert np.array_equal(file.grids["empty"], empty)
    assert np.array_equal(file.grids["single"], single)


@CHECK_ALL
@given(data=st.data(), half=st.booleans(), up=st.sampled_from("yz"), components=st.sampled_from([1, 3]))
def test_round_trip_of_random_sparse_arrays(tmp_path_factory, data, half, up, components):
    """Whatever the values, what was written is what is read."""
    shape = data.draw(st.tuples(*[st.integers(1, 20)] * 3)) + ((3,) if components == 3 else ())
    width = 16 if half else 32
    values = st.floats(width=width, allow_nan=False, allow_infinity=False)
    array = data.draw(arrays(np.float32, shape, elements=values, fill=st.just(0.0)))
    path = tmp_path_factory.mktemp("vdb") / "a.vdb"
    assert np.array_equal(written(path, {"a": array}, half=half, up=up).grids["a"], array)


def test_transposed_and_integer_arrays(tmp_path):
    """Any memory order and any real dtype is written by value."""
    array = np.arange(3 * 4 * 5).reshape(3, 4, 5)
    assert np.array_equal(written(tmp_path / "a.vdb", {"a": array.T}).grids["a"], array.T.astype(np.float32))


def test_threshold_drops_and_lost_mass_tells(tmp_path):
    """Voxels at or below the threshold become 0, per grid where asked; their share of the mass is known."""
    density = np.array([0.0, 0.5, -1.0, 2.0, 4.5], np.float32).reshape(5, 1, 1)
    file = written(tmp_path / "a.vdb", {"density": density}, threshold=1.0)
    assert file.grids["density"].ravel().tolist() == [0, 0, 0, 2, 4.5]
    assert lost_mass(density, 1.0) == pytest.approx(1.5 / 8)
    assert lost_mass(density, 0.0) == 0
    assert lost_mass(np.zeros((2, 2, 2)), 1.0) == 0
    file = written(tmp_path / "b.vdb", {"density": density, "heat": density}, threshold={"heat": 1.0})
    assert np.array_equal(file.grids["density"], density)
    assert file.grids["heat"].ravel().tolist() == [0, 0, 0, 2, 4.5]


def test_metadata_comes_back(tmp_path):
    """Floats, integers, text and booleans keep type and value."""
    facts = {"fps": 0.1, "frame": 2**40, "shot": "bluecher é", "loop": True, "none": "", "seven": np.int32(7)}
    file = written(tmp_path / "a.vdb", {"density": np.ones((2, 2, 2))}, metadata=facts)
    assert file.metadata == facts | {"creator": "warpfluid"}
    assert {name: type(value) for name, value in file.metadata.items()} == {
        "creator": str, "fps": float, "frame": int, "shot": str, "loop": bool, "none": str, "seven": int
    }  # fmt: skip


def test_same_data_same_bytes(tmp_path):
    """Files are deterministic, and other data make another id."""
    for name, value in (("a", 1), ("b", 1), ("c", 2)):
        write_vdb(tmp_path / name, {"density": np.full((9, 9, 9), value)}, metadata={"x": 1, "y": 2})
    a, b, c = ((tmp_path / name).read_bytes() for name in "abc")
    assert a == b
    assert a[21:57] != c[21:57]


def test_some_grids_only(tmp_path):
    """With names the others are passed over."""
    write_vdb(tmp_path / "a.vdb", {"a": np.ones((2, 2, 2)), "b": np.full((2, 2, 2), 2), "c": np.ones((2, 2, 2))})
    file = read_vdb(tmp_path / "a.vdb", names=["b"])
    assert list(file.grids) == ["b"]
    assert (file.grids["b"] == 2).all()
    with pytest.raises(ValueError, match="no grid d; it has a, b, c"):
        read_vdb(tmp_path / "a.vdb", names=["d"])


@pytest.mark.parametrize(
    ("grids", "options", "message"),
    [
        ({}, {}, "grids is empty"),
        ({"a": np.zeros((2, 2))}, {}, r"'a' has shape \(2, 2\)"),
        ({"a": np.zeros((2, 2, 2, 2))}, {}, "has shape"),
        ({"a": np.zeros((2, 0, 2))}, {}, "has shape"),
        ({"a": np.full((2, 2, 2), np.nan)}, {}, "holds NaN"),
        ({"a": np.full((2, 2, 2), -np.inf)}, {}, "holds NaN, infinity"),
        ({"a": np.full((2, 2, 2), 1e39)}, {}, "more than float32"),
        ({"a": np.full((2, 2, 2), -7e4)}, {"half": True}, "largest half"),
        ({"a": np.zeros((2, 2, 2), complex)}, {}, "holds complex128"),
        ({"": np.zeros((2, 2, 2))}, {}, "grid name ''"),
        ({"a": np.zeros((2, 2, 2)), "b": np.zeros((2, 2, 3))}, {}, "must have one shape"),
        ({"a": np.zeros((2, 2, 2))}, {"up": "x"}, "up is 'x'"),
        ({"a": np.zeros((2, 2, 2))}, {"voxel_size": 0}, "voxel_size is 0"),
        ({"a": np.zeros((2, 2, 2))}, {"voxel_size": np.inf}, "voxel_size is inf"),
        ({"a": np.zeros((2, 2, 2))}, {"origin": (0, 0)}, "origin is"),
        ({"a": np.zeros((2, 2, 2))}, {"threshold": -1}, "threshold of grid 'a' is -1"),
        ({"a": np.zeros((2, 2, 2))}, {"metadata": {"x": None}}, "metadata 'x' is None"),
        ({"a": np.zeros((2, 2, 2))}, {"metadata": {"x": 2**63}}, "metadata 'x' is"),
    ],
)
def test_wrong_arguments_are_named(tmp_path, grids, options, message):
    """A wrong argument ends in an error that names it, and leaves no file."""
    with pytest.raises(ValueError, match=message):
        write_vdb(tmp_path / "a.vdb", grids, **options)
    assert not os.listdir(tmp_path)


def test_file_appears_whole_or_not_at_all(tmp_path, monkeypatch):
    """When writing fails the old file stays, no temporary one does, and the error names the file."""
    path = tmp_path / "a.vdb"
    write_vdb(path, {"density": np.ones((2, 2, 2))})
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError, match=r"No space left.*a\.vdb"):
        write_vdb(path, {"density": np.zeros((2, 2, 2))})
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.vdb"]
    with pytest.raises(OSError, match="nowhere"):
        write_vdb(tmp_path / "nowhere" / "a.vdb", {"density": np.ones((2, 2, 2))})


def test_foreign_and_missing_files(tmp_path):
    """What is no .vdb file is refused by name."""
    path = tmp_path / "a.vdb"
    for data in (b"", b"\x93NUMPY", bytes(1000), b" BDV"):
        path.write_bytes(data)
        with pytest.raises(ValueError, match=r"a\.vdb: this is not an OpenVDB file"):
            read_vdb(path)
    with pytest.raises(FileNotFoundError):
        read_vdb(tmp_path / "b.vdb")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"Tree_float_5_4_3", b"Tree_int32_5_4_3", "type 'Tree_int32_5_4_3'"),
        (struct.pack("<I", 224), struct.pack("<I", 100), "its format is 100, not 222 to 225"),
        (b"UniformScaleTranslateMap", b"NonlinearFrustumTransfrm", "is turned"),
    ],
)
def test_files_of_other_kinds_say_the_way_out(tmp_path, old, new, message):
    """A tree, a format or a transform that is not read is named."""
    path = tmp_path / "a.vdb"
    write_vdb(path, {"density": np.ones((9, 9, 9))})
    path.write_bytes(unsigned(path.read_bytes().replace(old, new)))
    with pytest.raises(ValueError, match=message):
        read_vdb(path)


def with_blosc(path, block):
    """Replace the values of a file's only leaf by a block packed with Blosc."""
    write_vdb(path, {"density": np.ones((8, 8, 8))})
    data = path.read_bytes()
    zip_mask, blosc_mask = struct.pack("<II", 3, 9), struct.pack("<II", 6, 9)  # compression, number of facts
    assert data.count(zip_mask) == 1
    data = data.replace(zip_mask, blosc_mask)
    leaf = data.rindex(b"\xff" * 64) + 65
    path.write_bytes(unsigned(data[:leaf] + struct.pack("<q", len(block)) + block))


def blosc_block(flags, stream, part=2048):
    """Return a block of one unsplit part with Blosc's header."""
    body = stream if flags & 2 else struct.pack("<II", 20, len(stream)) + stream
    return struct.pack("<4B3I", 2, 1, flags, 4, 2048, part, 16 + len(body)) + body


LZ4 = 1 << 5 | 16
# Four new bytes, 15 + 7 * 255 + 235 + 4 = 2039 copied from four back, then five new, as LZ4 has to end.
ONES = b"\x4f\x00\x00\x80\x3f\x04\x00" + b"\xff" * 7 + b"\xeb" + b"\x50\x3f\x00\x00\x80\x3f"


def test_blosc_blocks_are_opened(tmp_path):
    """Blocks that are stored, packed, or packed and shuffled hold what LZ4 and Blosc say they do."""
    path, values = tmp_path / "a.vdb", np.arange(512, dtype=np.float32)
    with_blosc(path, blosc_block(2, values.tobytes()))
    assert np.array_equal(read_vdb(path).grids["density"].ravel(), values)
    with_blosc(path, blosc_block(LZ4, ONES))
    assert (read_vdb(path).grids["density"] == 1).all()
    shuffled = np.frombuffer(values.tobytes(), np.uint8).reshape(512, 4).T.tobytes()
    with_blosc(path, blosc_block(LZ4 | 1, b"\xf0" + b"\xff" * 7 + b"\xf8" + shuffled))
    assert np.array_equal(read_vdb(path).grids["density"].ravel(), values)


@pytest.mark.parametrize(
    ("block", "message"),
    [
        (b"short", "has no header"),
        (blosc_block(2, bytes(2047)), "has 2047 bytes where 2048 belong"),
        (blosc_block(3 << 5 | 16, ONES), "not with its LZ4; save it again with zip"),
        (blosc_block(LZ4, ONES[:1] + b"\0"), "has 1 bytes where 4 belong"),
        (blosc_block(LZ4, ONES[:6]), "ends too early"),
        (blosc_block(LZ4, ONES[:5] + b"\x05" + ONES[6:]), "copies what is not there"),
        (blosc_block(LZ4, ONES[:-6]), "ends too early"),
        (blosc_block(LZ4, ONES, part=0), "parts of no size"),
    ],
)
def test_damaged_blosc_blocks_end_in_an_error(tmp_path, block, message):
    """A block that cannot be what it says is refused."""
    with_blosc(tmp_path / "a.vdb", block)
    with pytest.raises(ValueError, match=message):
        read_vdb(tmp_path / "a.vdb")


def unsigned(data):
    """Return the file as another program would have saved it, without a checksum."""
    return data[:ID_VERSION] + b"4" + data[ID_VERSION + 1 :]


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    """The bytes of a small file of two grids, one half of it vectors."""
    path = tmp_path_factory.mktemp("sample") / "a.vdb"
    density = sparse((20, 9, 130))
    write_vdb(path, {"density": density, "velocity": np.stack([density] * 3, axis=-1)}, voxel_size=0.5)
    return path.read_bytes()


@CHECK_ALL
@given(share=st.floats(0, 1, exclude_max=True), checked=st.booleans())
def test_truncated_files_end_in_an_error(tmp_path_factory, sample, share, checked):
    """A file that was cut short anywhere is refused, with checksum and without."""
    path = tmp_path_factory.mktemp("cut") / "a.vdb"
    path.write_bytes((sample if checked else unsigned(sample))[: int(share * len(sample))])
    with pytest.raises(ValueError, match=r"a\.vdb: "):
        read_vdb(path)


@CHECK_ALL
@given(where=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_is_found(tmp_path_factory, sample, where, bit):
    """The checksum finds any one bit in what a grid holds."""
    head = sample.index(b"Tree_float")
    path = tmp_path_factory.mktemp("flip") / "a.vdb"
    data = bytearray(sample)
    data[head + int(where * (len(data) - head))] ^= 1 << bit
    path.write_bytes(data)
    with pytest.raises(ValueError, match="checksum"):
        read_vdb(path)


@settings(max_examples=150, deadline=2000, derandomize=True)
@given(data=st.data())
def test_flipped_bytes_never_crash(tmp_path_factory, sample, data):
    """Without the checksum too, damage gives an array or an error, soon and without gigabytes."""
    damaged = bytearray(unsigned(sample))
    early = st.integers(57, 2000)  # metadata, transform and root, where a byte weighs most
    anywhere = st.integers(0, len(damaged) - 1)
    for place in data.draw(st.lists(early | anywhere, min_size=1, max_size=4)):
        damaged[place] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("bytes") / "a.vdb"
    path.write_bytes(unsigned(bytes(damaged)))
    with contextlib.suppress(ValueError):
        read_vdb(path)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_far_node_does_not_fill_the_memory(tmp_path, axis):
    """A node whose place was damaged to lie a world apart is refused before the box is filled."""
    path = tmp_path / "a.vdb"
    array = np.zeros((4100, 2, 2), np.float32)
    array[[0, -1]] = 1
    write_vdb(path, {"density": array})
    far = [4096, 0, 0]
    far[axis] = 2**30
    data = path.read_bytes().replace(struct.pack("<3i", 4096, 0, 0), struct.pack("<3i", *far))
    path.write_bytes(unsigned(data))
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="damaged or nearly empty: 8 voxels"):
            read_vdb(path)
        assert tracemalloc.get_traced_memory()[1] < 2**26
    finally:
        tracemalloc.stop()


def test_what_was_written_is_read_however_empty(tmp_path, monkeypatch):
    """The checksum vouches for a large volume of nothing; without it voxels count, not their components."""
    path, shape = tmp_path / "a.vdb", (9, 10, 11)
    write_vdb(path, {"density": np.zeros(shape), "velocity": np.zeros((*shape, 3))})
    for limit in ("EMPTY", "TRUSTED"):
        monkeypatch.setattr(limits, limit, 100, raising=False)
    assert read_vdb(path).grids["velocity"].shape == (*shape, 3)
    path.write_bytes(unsigned(path.read_bytes()))
    with pytest.raises(ValueError, match="damaged or nearly empty: 0 voxels in a box of 990"):
        read_vdb(path)
    monkeypatch.setattr(limits, "EMPTY", 990)
    assert read_vdb(path).grids["density"].shape == shape


def test_a_packed_block_opens_to_its_size_only(tmp_path):
    """A block that would unpack to more than a leaf holds is refused."""
    path = tmp_path / "a.vdb"
    write_vdb(path, {"density": np.ones((8, 8, 8))})
    data = path.read_bytes()
    masks = b"\xff" * 64
    leaf = data.rindex(masks) + len(masks) + 1
    bomb = zlib.compress(bytes(10**6))
    path.write_bytes(unsigned(data[:leaf] + struct.pack("<q", len(bomb)) + bomb))
    with pytest.raises(ValueError, match="opens to 2049 bytes where 2048 belong"):
        read_vdb(path)
