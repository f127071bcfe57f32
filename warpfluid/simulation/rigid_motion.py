"""How rigid bodies move: carried by the fluid, pulled down, stopped by level ground."""

import numpy as np
from scipy.spatial.transform import Rotation

from warpfluid.simulation.contact import choose, collide
from warpfluid.simulation.drag import Flow, drag_at
from warpfluid.simulation.rigid_body import RigidBody

LONGEST_STEP = 1 / 240  # s
TOUCH = 2e-3  # voxels; what is this near the ground touches it
EVENTS = 8  # collisions in one step; then the body rests
HALVINGS = 14  # of a step, to find the moment of touching
SLEEP_AFTER = 0.25  # s


def advance(
    body: RigidBody, time_step: float, *, gravity: float = 0.0, ground: float = -0.5, flow: Flow | None = None
) -> None:
    """Move a body for a time step: carried by the flow, pulled down, stopped by the ground.

    The flow is asked once; its drag is linear in the difference of speeds and is integrated implicitly, so no
    coupling is too strong. Free fall is exact. Energy never grows by touching the ground.

    Args:
        body: What moves, changed in place.
        time_step: [s].
        gravity: Downward acceleration [voxel/s^2].
        ground: Height of the ground [voxel]; minus infinity where there is none.
        flow: The fluid around it; still air of no density by default.

    Raises:
        ValueError: If the time step is not positive.
        FloatingPointError: If the flow is not finite.
    """
    if not time_step > 0:
        raise ValueError(f"time_step is {time_step}, expected a number above 0")
    drag, push = _drag(body, flow) if flow else (np.zeros((6, 6)), np.zeros(6))
    if not (np.isfinite(drag).all() and np.isfinite(push).all()):
        raise FloatingPointError("the fluid around a body has velocities or densities that are not finite")
    push = push + body.mass * np.array([0, -gravity, 0, 0, 0, 0])
    if body.asleep and not _wakes(body, push, gravity):
        return
    body.asleep = False
    count = max(int(np.ceil(time_step / LONGEST_STEP - 1e-9)), 1)
    for _ in range(count):
        _step(body, time_step / count, gravity, ground, drag, push)


def _drag(body: RigidBody, flow: Flow) -> tuple[np.ndarray, np.ndarray]:
    """Return the drag as a matrix on (velocity, spin), and the force and torque on a body at rest."""
    arms = body.points @ body.rotation.T
    speeds, densities = flow(arms + body.position)
    weights = body.coupling * body.volume * body.shares * densities
    return drag_at(arms, speeds, weights)


def _wakes(body: RigidBody, push: np.ndarray, gravity: float) -> bool:
    """Return whether the flow pushes about as hard as friction and weight hold."""
    sideways, up = np.hypot(push[0], push[2]), push[1] + body.mass * gravity
    reach = np.linalg.norm(body.hull, axis=1).max()
    torque = np.linalg.norm(push[3:]) / reach
    hold = 0.5 * body.mass * gravity
    return bool(max(sideways, torque) > min(body.friction, 1.0) * hold or up > hold)


def _step(body: RigidBody, step: float, gravity: float, ground: float, drag: np.ndarray, push: np.ndarray) -> None:
    """Fly, collide, fly on; rest where that ends too soon."""
    slow = 2 * gravity * step  # approaching slower than this is no bounce
    left, rate = step, _acceleration(body, step, drag, push)
    for _ in range(EVENTS):
        arms = body.hull @ body.rotation.T
        touching = arms[arms[:, 1] + body.position[1] - ground < TOUCH]
        rising = (body.velocity + np.cross(body.spin, touching))[:, 1]
        if (rising < -slow).any():
            _bounce(body, touching, slow)
        elif (rising <= slow).any():
            break
        else:
            fall = _time_to_touch(body, left, rate, ground)
            _fly(body, fall, rate)
            left -= fall
            body.still = 0.0
        if left <= 0:
            return
    _rest(body, left, rate, gravity, ground)
    _fall_asleep(body, step, 0.25 * slow)


def _acceleration(body: RigidBody, step: float, drag: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Return the change per second of (velocity, spin), with implicit drag."""
    inertia = np.zeros((6, 6))
    inertia[:3, :3], inertia[3:, 3:] = body.mass * np.eye(3), body.turned_inertia()
    return np.linalg.solve(inertia + step * drag, push - drag @ np.concatenate([body.velocity, body.spin]))


def _after(body: RigidBody, seconds: float, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return position and quaternion after a free flight."""
    position = body.position + seconds * body.velocity + 0.5 * seconds**2 * rate[:3]
    momentum = body.turned_inertia() @ (body.spin + 0.5 * seconds * rate[3:])
    half = Rotation.from_rotvec(0.5 * seconds * body.spin) * Rotation.from_quat(body.quaternion)
    middle = half.as_matrix()
    spin = middle @ np.linalg.solve(body.inertia, middle.T @ momentum)
    return position, (Rotation.from_rotvec(seconds * spin) * Rotation.from_quat(body.quaternion)).as_quat()


def _fly(body: RigidBody, seconds: float, rate: np.ndarray) -> None:
    """Move freely; turning keeps its momentum's direction and its energy."""
    body.position, quaternion = _after(body, seconds, rate)
    body.velocity = body.velocity + seconds * rate[:3]
    _turn_to(body, quaternion, body.spin + seconds * rate[3:])


def _turn_to(body: RigidBody, quaternion: np.ndarray, spin: np.ndarray) -> None:
    """Change the orientation and keep the angular momentum's direction and the energy of turning."""
    inertia = body.turned_inertia()
    momentum, energy = inertia @ spin, spin @ inertia @ spin
    body.quaternion = quaternion / np.linalg.norm(quaternion)
    inertia = body.turned_inertia()
    body.spin = np.linalg.solve(inertia, momentum)
    body.spin *= np.sqrt(energy / max(body.spin @ inertia @ body.spin, 1e-300))


def _time_to_touch(body: RigidBody, seconds: float, rate: np.ndarray, ground: float) -> float:
    """Return when the lowest point meets the ground, or all the time there is."""

    def height(at: float) -> float:
        position, quaternion = _after(body, at, rate)
        turned = Rotation.from_quat(quaternion).as_matrix()
        return float((body.hull @ turned[1]).min() + position[1] - ground)

    if height(seconds) >= 0:
        return seconds
    above, below = 0.0, seconds
    for _ in range(HALVINGS):
        middle = 0.5 * (above + below)
        above, below = (middle, below) if height(middle) >= 0 else (above, middle)
    return above


def _bounce(body: RigidBody, arms: np.ndarray, slow: float) -> None:
    """Collide with the ground at touching points."""
    arms, energy = arms[choose(arms)], body.energy
    speeds = body.velocity + np.cross(body.spin, arms)
    targets = np.where(speeds[:, 1] < -slow, -body.restitution * speeds[:, 1], 0.0)
    _push(body, arms, speeds, targets)
    _limit(body, energy)


def _rest(body: RigidBody, seconds: float, rate: np.ndarray, gravity: float, ground: float) -> None:
    """Move on while the ground holds: no point sinks, and energy does not grow."""
    weight, before = body.mass * gravity, body.velocity[1]
    body.velocity, body.spin = body.velocity + seconds * rate[:3], body.spin + seconds * rate[3:]
    bound = body.energy + weight * seconds * 0.5 * (before + body.velocity[1])
    arms = body.hull @ body.rotation.T
    gaps = arms[:, 1] + body.position[1] - ground
    speeds = body.velocity + np.cross(body.spin, arms)
    held = np.flatnonzero((gaps + seconds * speeds[:, 1] < 0) | (gaps < TOUCH))
    if held.size:
        held = held[choose(arms[held])]
        _push(body, arms[held], speeds[held], -np.maximum(gaps[held], 0) / seconds)
    _limit(body, bound, climb=weight * seconds * body.velocity[1])
    body.position = body.position + seconds * body.velocity
    turned = Rotation.from_rotvec(seconds * body.spin) * Rotation.from_quat(body.quaternion)
    _turn_to(body, turned.as_quat(), body.spin)
    sunk = ground - (body.hull @ body.rotation.T)[:, 1].min() - body.position[1]
    if sunk > 0:
        body.position[1] += sunk
        _limit(body, body.energy - weight * sunk)


def _push(body: RigidBody, arms: np.ndarray, speeds: np.ndarray, targets: np.ndarray) -> None:
    """Let the ground push points up to target speeds."""
    inverse = np.linalg.inv(body.turned_inertia())
    change, turn = collide(arms, speeds, body.mass, inverse, targets, body.friction)
    body.velocity, body.spin = body.velocity + change, body.spin + turn


def _limit(body: RigidBody, energy: float, climb: float = 0.0) -> None:
    """Slow all motion down evenly until kinetic energy and climb fit in; contacts that part still part."""
    if (now := body.energy) + climb > energy:
        root = np.sqrt(max(climb**2 + 4 * now * energy, 0.0))
        factor = np.clip((root - climb) / (2 * now), 0, 1) if now > 0 else 0.0
        body.velocity, body.spin = factor * body.velocity, factor * body.spin


def _fall_asleep(body: RigidBody, step: float, slow: float) -> None:
    """Stop a body that has hardly moved for a while."""
    body.still = body.still + step if body.energy <= 0.5 * body.mass * slow**2 else 0.0
    if body.still > SLEEP_AFTER:
        body.asleep, body.still = True, 0.0
        body.velocity, body.spin = np.zeros(3), np.zeros(3)
