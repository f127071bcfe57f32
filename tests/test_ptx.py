"""Every kernel compiles for NVIDIA cards, which takes no card."""

import importlib
import pkgutil

import pytest
import warp as wp

from warpfluid import kernels

MODULES = {
    name.removeprefix("warpfluid.kernels."): importlib.import_module(name)
    for _, name, is_package in pkgutil.walk_packages(kernels.__path__, "warpfluid.kernels.")
    if not is_package
}
KERNELS = {
    name: [
        value.key
        for value in vars(module).values()
        if isinstance(value, wp.Kernel) and value.module.name == module.__name__
    ]
    for name, module in MODULES.items()
}


def test_kernels_are_found():
    """Otherwise the test below would pass without a word."""
    assert {"blur", "fluid.transport", "tomography.projection", "vectors"} <= {
        name for name, keys in KERNELS.items() if keys
    }


@pytest.mark.parametrize("arch", [75, 90])
@pytest.mark.parametrize("name", [name for name, keys in KERNELS.items() if keys])
def test_compiles_to_ptx(name, arch, tmp_path):
    """From Turing to Hopper, with an entry point for each kernel."""
    wp.compile_aot_module(MODULES[name], device=None, arch=arch, use_ptx=True, module_dir=tmp_path)
    (file,) = tmp_path.glob("*.ptx")
    text = file.read_text()
    assert f".target sm_{arch}" in text
    for key in KERNELS[name]:
        assert f".entry {key}" in text
