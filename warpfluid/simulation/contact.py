"""Impulses between a rigid body and level ground, with Coulomb's friction."""

import numpy as np

from warpfluid.simulation.drag import crosses

SWEEPS = 60  # over all contacts; four corners of a box need about twenty
ENOUGH = 1e-7  # of the fastest contact's speed: no sweep changes more
MOST_CONTACTS = 8


def choose(points: np.ndarray) -> np.ndarray:
    """Return which of many touching points hold the body: the outermost ones seen from above.

    Args:
        points: Shape (n, 3), y up.

    Returns:
        Indices of at most eight of them.
    """
    if len(points) <= MOST_CONTACTS:
        return np.arange(len(points))
    around = 2 * np.pi * (np.arange(MOST_CONTACTS) + 0.3) / MOST_CONTACTS
    return np.unique((points[:, [0, 2]] @ np.stack([np.cos(around), np.sin(around)])).argmax(axis=0))


def collide(
    arms: np.ndarray,
    speeds: np.ndarray,
    mass: float,
    inverse_inertia: np.ndarray,
    targets: np.ndarray,
    friction: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Find the impulses that stop contacts from approaching (Gauss-Seidel over contacts, Moreau 1988).

    Args:
        arms: From the centre of mass to each contact, shape (n, 3), y up.
        speeds: Velocity of the body at each contact, shape (n, 3).
        mass: Of the body.
        inverse_inertia: Of the body about its centre of mass, shape (3, 3).
        targets: Least upward speed after the collision, shape (n,).
        friction: Largest share of the upward impulse that acts along the ground.

    Returns:
        The changes of velocity and of angular velocity, each of shape (3,).
    """
    count = len(arms)
    cross = crosses(arms)
    turning = np.einsum("aij,jk,blk->abil", cross, inverse_inertia, cross)
    response = (np.eye(3) / mass + turning).transpose(0, 2, 1, 3).reshape(3 * count, 3 * count)
    impulse, start = np.zeros(3 * count), speeds.reshape(-1)
    enough = ENOUGH * np.abs(speeds).max() + 1e-300
    for _ in range(SWEEPS):
        change = max(_push(impulse, i, start, response, targets[i], friction) for i in range(count))
        if change < enough:
            break
    pushes = impulse.reshape(count, 3)
    return pushes.sum(axis=0) / mass, inverse_inertia @ np.cross(arms, pushes).sum(axis=0)


def _push(
    impulse: np.ndarray, i: int, start: np.ndarray, response: np.ndarray, target: float, friction: float
) -> float:
    """Correct one contact's impulse, in place, and return by what speed that changes the contact."""
    x, y, z = 3 * i, 3 * i + 1, 3 * i + 2
    before = impulse[x : z + 1].copy()
    speed = start[y] + response[y] @ impulse
    impulse[y] = max(impulse[y] - (speed - target) / response[y, y], 0.0)
    if friction:
        along = [x, z]
        slip = start[along] + response[along] @ impulse
        # One number for both directions, or friction would not point against the slip.
        wanted = impulse[along] - slip / (response[x, x] + response[z, z])
        most, length = friction * impulse[y], np.hypot(*wanted)
        impulse[along] = wanted if length <= most else wanted * (most / length)
    return float(np.abs(impulse[x : z + 1] - before).max() * response[y, y])
