"""Burning against its law, and the balance of fuel."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.kernels.fluid.combustion import burn_fuel

SHAPE = (6, 17, 50)
NAMES = ("fuel", "temperature", "density", "flame")
LAW = {
    "burn_rate": 3.0,
    "ignition": 0.3,
    "hottest": 1.5,
    "heat": 0.2,
    "smoke": 0.7,
    "expansion": 0.1,
    "flame_decay": 2.0,
    "time_step": 0.1,
}


def gas(device, seed=0):
    """Fuel in half of the box, at temperatures up to beyond the hottest."""
    rng = np.random.default_rng(seed)
    fuel = 10 * rng.random(SHAPE) * (rng.random(SHAPE) < 0.5)
    arrays = (fuel, rng.uniform(-0.2, 2, SHAPE), rng.random(SHAPE), rng.random(SHAPE))
    return {name: wp.array(a, dtype=float, device=device) for name, a in zip(NAMES, arrays, strict=True)}


def read(arrays):
    return {name: array.numpy().astype(float) for name, array in arrays.items()}


def test_is_the_law(device):
    """All that burning changes."""
    arrays = gas(device)
    before = read(arrays)
    expansion = burn_fuel(**arrays, **LAW).numpy()
    after = read(arrays)
    hot = before["temperature"]
    burnt = before["fuel"] * (1 - np.exp(-0.3 * np.clip((hot - 0.3) / 1.2, 0, 1)))
    np.testing.assert_allclose(after["fuel"], before["fuel"] - burnt, atol=3e-6)
    np.testing.assert_allclose(after["temperature"], np.maximum(hot, np.minimum(hot + 0.2 * burnt, 1.5)), atol=1e-6)
    np.testing.assert_allclose(after["density"], before["density"] + 0.7 * burnt, atol=3e-6)
    np.testing.assert_allclose(after["flame"], before["flame"] * np.exp(-0.2) + burnt, atol=3e-6)
    np.testing.assert_allclose(expansion, 0.1 * burnt / 0.1, atol=3e-6)
    assert ((burnt > 0) == (expansion > 0)).all()
    assert 0.1 < (burnt > 0).mean() < 0.9


@given(
    burn_rate=st.floats(0, 50),
    ignition=st.floats(-0.5, 1.4),
    heat=st.floats(0, 5),
    time_step=st.floats(1e-3, 1),
    seed=st.integers(0, 9),
)
@settings(max_examples=20)
def test_fuel_is_neither_lost_nor_made(burn_rate, ignition, heat, time_step, seed):
    """What burns becomes smoke; nothing is negative, too hot or cooler than before."""
    arrays = gas("cpu", seed)
    before = read(arrays)
    numbers = {"burn_rate": burn_rate, "ignition": ignition, "heat": heat, "time_step": time_step, "smoke": 1.0}
    burn_fuel(**arrays, **(LAW | numbers))
    after = read(arrays)
    np.testing.assert_allclose(
        after["fuel"] + after["density"], before["fuel"] + before["density"], rtol=1e-6, atol=1e-6
    )
    assert (after["fuel"] >= 0).all()
    assert (after["temperature"] >= before["temperature"]).all()
    assert after["temperature"].max() <= max(np.float32(1.5), before["temperature"].max())


def test_small_steps_are_one_large_one(device):
    """As long as the temperature stays."""
    once, often = gas(device), gas(device)
    numbers = LAW | {"heat": 0.0}
    burn_fuel(**once, **numbers)
    for _ in range(4):
        burn_fuel(**often, **(numbers | {"time_step": LAW["time_step"] / 4}))
    for name in ("fuel", "density"):
        np.testing.assert_allclose(once[name].numpy(), often[name].numpy(), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("nothing", [{"burn_rate": 0.0}, {"ignition": 10.0, "hottest": 11.0}])
def test_where_nothing_burns_nothing_changes(nothing, device):
    """Not a bit; only the flame is forgotten, if it is."""
    arrays = gas(device)
    before = {name: array.numpy().copy() for name, array in arrays.items()}
    expansion = burn_fuel(**arrays, **(LAW | nothing | {"flame_decay": 0.0}))
    assert not expansion.numpy().any()
    for name in NAMES:
        np.testing.assert_array_equal(arrays[name].numpy(), before[name])


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    """One thread or three."""
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        arrays = gas("cpu")
        results.append([burn_fuel(**arrays, **LAW).numpy(), *(array.numpy() for array in arrays.values())])
    np.testing.assert_array_equal(*results)


@pytest.mark.parametrize("wrong", [{"burn_rate": -1.0}, {"flame_decay": -1.0}, {"time_step": 0.0}, {"hottest": 0.3}])
def test_refuses_senseless_numbers(wrong, device):
    """Each is named."""
    with pytest.raises(ValueError, match=next(iter(wrong))):
        burn_fuel(**gas(device), **(LAW | wrong))
