"""VTK image data: read back by ourselves and by PyVista."""

import numpy as np
import pytest
import pyvista

from warpfluid.files.vti import read_vti, vti_facts, write_vti

GRIDS = {
    "one voxel": {"density": np.full((1, 1, 1), 2.5, np.float32)},
    "odd": {
        "density": np.random.default_rng(0).normal(size=(5, 3, 7)).astype(np.float32),
        'vel"&<': np.random.default_rng(1).normal(size=(5, 3, 7, 3)).astype(np.float32),
    },
    "empty": {"density": np.zeros((4, 5, 6), np.float32)},
    "blocks": {"density": np.random.default_rng(2).random((70, 80, 90)).astype(np.float32)},  # more than one of 1 MB
    "a whole block": {"density": np.arange(2**18, dtype=np.float32).reshape(64, 64, 64)},
}


@pytest.mark.parametrize("case", GRIDS)
def test_pyvista_reads_it(tmp_path, case):
    """Values at points, which are the centres of our voxels."""
    write_vti(tmp_path / "a.vti", GRIDS[case], voxel_size=0.25, origin=(1, -2, 3))
    image = pyvista.read(tmp_path / "a.vti")
    assert image.origin == (1, -2, 3)
    assert image.spacing == (0.25, 0.25, 0.25)
    for name, grid in GRIDS[case].items():
        assert image.dimensions == grid.shape[:3]
        values = image.point_data[name].reshape(*image.dimensions, -1, order="F")
        np.testing.assert_array_equal(values.reshape(grid.shape), grid)


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("case", GRIDS)
def test_round_trip(tmp_path, case, up):
    """And the facts, without the values, say the same of sizes and places."""
    write_vti(tmp_path / "a.vti", GRIDS[case], voxel_size=0.25, origin=(1, -2, 3), up=up)
    file = read_vti(tmp_path / "a.vti")
    facts = vti_facts(tmp_path / "a.vti")
    assert [grid.name for grid in facts] == list(GRIDS[case])
    for grid in facts:
        assert (grid.box[1] - grid.box[0] + 1).tolist() == list(file.grids[grid.name].shape[:3])
        assert grid.shift == file.origin
        assert grid.kind == ("float" if file.grids[grid.name].ndim == 3 else "vec3s")
    for name, grid in GRIDS[case].items():
        turned = grid if up == "y" else grid.swapaxes(1, 2)[:, ::-1]
        if up == "z" and grid.ndim == 4:
            turned = turned[..., [0, 2, 1]] * np.float32([1, -1, 1])
        np.testing.assert_array_equal(file.grids[name], turned)


def test_files_of_pyvista(tmp_path):
    """Values in cells lie half a voxel aside; those at points do not."""
    image = pyvista.ImageData(dimensions=(5, 4, 3), spacing=(0.5, 0.5, 0.5), origin=(1, 2, 3))
    image.cell_data["density"] = np.arange(24, dtype=np.float64)
    image.save(tmp_path / "a.vti")
    file = read_vti(tmp_path / "a.vti")
    assert file.origin == (1.25, 2.25, 3.25)
    np.testing.assert_array_equal(file.grids["density"], np.arange(24).reshape(4, 3, 2, order="F"))
    (facts,) = vti_facts(tmp_path / "a.vti")
    assert (facts.shift, (facts.box[1] - facts.box[0] + 1).tolist()) == (file.origin, [4, 3, 2])
    image = pyvista.ImageData(dimensions=(5, 4, 3), spacing=(0.5, 0.5, 0.7))
    image["density"] = np.zeros(60)
    image.save(tmp_path / "b.vti")
    with pytest.raises(ValueError, match=r"b\.vti: its voxels are \[0\.5, 0\.5, 0\.7\], no cubes"):
        read_vti(tmp_path / "b.vti")


@pytest.mark.parametrize("content", [b"", b"hello", b"<VTKFile type='ImageData'>"])
def test_what_is_none(tmp_path, content):
    """The file is named."""
    (tmp_path / "a.vti").write_bytes(content)
    for read in (read_vti, vti_facts):
        with pytest.raises(ValueError, match=r"a\.vti: "):
            read(tmp_path / "a.vti")


def test_a_file_cut_short(tmp_path):
    """It is refused."""
    write_vti(tmp_path / "a.vti", GRIDS["blocks"])
    data = (tmp_path / "a.vti").read_bytes()
    (tmp_path / "a.vti").write_bytes(data[: len(data) // 2])
    with pytest.raises(ValueError, match=r"a\.vti: the file is damaged"):
        read_vti(tmp_path / "a.vti")


@pytest.mark.parametrize("mode", ["Appended", "Binary", "Ascii"])
@pytest.mark.parametrize("coded", [0, 1])
@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("bits", [32, 64])
def test_every_encoding_of_vtk(tmp_path, mode, coded, packed, bits):
    """Values as text, as base64, as bytes, packed or not, of either byte order, at points and in cells."""
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

    path, chance = tmp_path / "a.vti", np.random.default_rng(0)
    for cells, dtype, order in ((False, np.float64, "Little"), (True, np.int16, "Big")):
        image = pyvista.ImageData(dimensions=(20, 15, 25), spacing=(0.5, 0.5, 0.5), origin=(1, 2, 3))
        image.offset = (2, -3, 0)
        data = image.cell_data if cells else image.point_data
        count = image.n_cells if cells else image.n_points
        data["density"] = (100 * chance.random(count)).astype(dtype)
        data["<a> & b"] = chance.normal(size=(count, 3)).astype(np.float32)
        writer = vtkXMLImageDataWriter()
        writer.SetFileName(str(path))
        writer.SetInputData(image)
        getattr(writer, f"SetDataModeTo{mode}")()
        getattr(writer, f"SetByteOrderTo{order}Endian")()
        writer.SetEncodeAppendedData(coded)
        writer.SetHeaderType(bits)
        writer.SetCompressorTypeToZLib() if packed else writer.SetCompressorTypeToNone()
        writer.Write()
        file, facts = read_vti(path), vti_facts(path)
        sides = np.array(image.dimensions) - cells
        assert [grid.name for grid in facts] == list(file.grids) == ["density", "<a> & b"]
        for name, grid in file.grids.items():
            values = data[name].astype(np.float32)
            np.testing.assert_array_equal(grid, np.swapaxes(values.reshape(*sides[::-1], *values.shape[1:]), 0, 2))
        np.testing.assert_allclose(file.origin, [1 + 1 + cells / 4, 2 - 1.5 + cells / 4, 3 + cells / 4])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (b'<Piece Extent="0', b'<Piece Extent="1', "in one piece"),
        (b"<ImageData ", b'<ImageData Direction="0 1 0 1 0 0 0 0 1" ', "no cubes"),
        (b"vtkZLibDataCompressor", b"vtkLZ4DataCompressor", "save it with ZLib"),
        (b'offset="0"', b'offset="99999999"', "no 8 bytes at byte"),
        (b'type="Float32"', b'type="String"', "an array of type 'String'"),
    ],
)
def test_what_is_not_read(tmp_path, old, new, words):
    """Parts of a volume, turned ones, other packings, values that are nowhere or no numbers: said by name."""
    write_vti(tmp_path / "a.vti", GRIDS["blocks"])
    (tmp_path / "a.vti").write_bytes((tmp_path / "a.vti").read_bytes().replace(old, new))
    with pytest.raises(ValueError, match=rf"a\.vti: .*{words}"):
        read_vti(tmp_path / "a.vti")
