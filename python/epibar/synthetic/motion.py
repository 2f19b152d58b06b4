"""How things move: boxes that fly and bounce, and people who walk."""

from __future__ import annotations

import numpy as np

from ..arguments import Array, Index


def rotations(axis: Array, angle: Array) -> Array:
    """Rotation matrices about unit axes (..., 3) by angles (...), by Rodrigues' formula: (..., 3, 3)."""
    x, y, z = np.moveaxis(axis, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    angle = angle[..., None, None]
    result: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return result


def flying_boxes(
    rng: np.random.Generator,
    count: int,
    seconds: Array,
    half_volume: tuple[float, float, float],
    size_m: tuple[float, float],
    thin: bool,
    speed: tuple[float, float],
) -> tuple[Array, Array]:
    """Boxes that fly straight, tumble, and bounce off the walls of a volume about the origin.

    Returns
    -------
    centres : (T, count, 3) array
    axes : (T, count, 3, 3) array
        Half-axes in columns.
    """
    reach = np.array(half_volume)
    velocity = rng.uniform(*speed, (count, 3)) * rng.choice([-1.0, 1.0], (count, 3))
    start = rng.uniform(0, 4, (count, 3)) * reach
    # Bouncing between −reach and reach is a triangle wave of period 4·reach.
    path = np.mod(start + seconds[:, None, None] * velocity, 4 * reach)
    centres = np.where(path < 2 * reach, path, 4 * reach - path) - reach
    edges = rng.uniform(*size_m, (count, 1)) * rng.uniform(0.85, 1.15, (count, 3))
    if thin:
        edges[:, 2] *= 3.0
        edges[:, 0] *= 0.5
    axis = rng.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    angle = rng.uniform(0, 2 * np.pi, count) + seconds[:, None] * rng.uniform(0.3, 1.5, count)
    turned = rotations(np.broadcast_to(axis, (len(seconds), count, 3)), angle)
    return centres, turned * (edges / 2)[:, None, :]


def walks(
    rng: np.random.Generator, count: int, frames: int, fps: float, half_floor: float = 5.0
) -> tuple[Array, Array, Array]:
    """Random waypoint walks on a floor: steady turning, 0.8–1.6 m/s, now and then a pause of 1–3 s.

    Returns
    -------
    position : (T, count, 2) array
        Metres.
    heading : (T, count) array
        Radians.
    speed : (T, count) array
        Metres per second.
    """
    inner = half_floor - 0.5
    place, goal = rng.uniform(-inner, inner, (2, count, 2))
    facing, pace = rng.uniform(-np.pi, np.pi, count), rng.uniform(0.8, 1.6, count)
    speed, pause, patience = pace.copy(), np.zeros(count), np.full(count, 8.0)
    out = np.empty((frames, count, 4))
    for frame in range(frames):
        toward = goal - place
        error = np.arctan2(toward[:, 1], toward[:, 0]) - facing
        error = (error + np.pi) % (2 * np.pi) - np.pi
        # Slow down in a turn, or a walker circles round a goal that is inside its turning circle.
        wanted = np.where(pause > 0, 0.0, pace * (0.4 + 0.6 * np.maximum(np.cos(error), 0.0)))
        speed += (wanted - speed) * min(1.0, 4.0 / fps)
        turn = np.clip(2.0 * error, -1.6, 1.6) * np.minimum(1.0, speed / 0.5)
        facing = facing + turn / fps
        place = place + (speed / fps)[:, None] * np.column_stack([np.cos(facing), np.sin(facing)])
        pause, patience = pause - 1 / fps, patience - 1 / fps
        out[frame] = np.column_stack([place, facing, speed])
        for walker in np.flatnonzero((np.hypot(*toward.T) < 0.5) | (patience < 0)):
            goal[walker] = rng.uniform(-inner, inner, 2)
            pace[walker], patience[walker] = rng.uniform(0.8, 1.6), 12.0
            if rng.random() < 0.2:
                pause[walker] = rng.uniform(1.0, 3.0)
    return out[..., :2], out[..., 2], out[..., 3]


def path_walks(
    rng: np.random.Generator, count: int, frames: int, fps: float, half_floor: float = 5.0
) -> tuple[Array, Array, Array]:
    """As `walks`, but everybody goes to and fro on one straight line through the middle of the floor."""
    seconds = np.arange(frames)[:, None] / fps
    pace = rng.uniform(0.8, 1.6, count)
    path = np.mod(rng.uniform(0, 4 * half_floor, count) + pace * seconds, 4 * half_floor)
    there = path < 2 * half_floor
    along = np.where(there, path, 4 * half_floor - path) - half_floor
    direction = rng.uniform(-np.pi, np.pi)
    position = along[..., None] * np.array([np.cos(direction), np.sin(direction)])
    heading = np.where(there, direction, direction + np.pi)
    return position, heading, np.broadcast_to(pace, (frames, count))


def bodies(
    rng: np.random.Generator, position: Array, heading: Array, speed: Array, fps: float
) -> tuple[Array, Array, Index]:
    """Walkers made of seven ellipsoids: head, trunk, hips, and legs and arms that swing with the gait.

    Parameters
    ----------
    position, heading, speed
        As from `walks`.

    Returns
    -------
    centres : (T, 7·count, 3) array
    axes : (T, 7·count, 3, 3) array
    owner : (7·count,) int array
        The walker of each part.
    """
    frames, count = heading.shape
    height = rng.uniform(1.55, 1.95, (count,))
    girth = rng.uniform(0.9, 1.25, (count,))
    ground = np.concatenate([position, np.zeros((frames, count, 1))], axis=2)
    flat = np.zeros_like(heading)
    forward = np.stack([np.cos(heading), np.sin(heading), flat], axis=2)
    left = np.stack([-np.sin(heading), np.cos(heading), flat], axis=2)
    up = np.array([0.0, 0.0, 1.0])
    phase = rng.uniform(0, 2 * np.pi, count) + 2 * np.pi * np.cumsum(speed, axis=0) / fps / (0.8 * height)
    swing = 0.5 * np.minimum(speed / 1.3, 1.2) * np.sin(phase)
    parts: list[tuple[Array, Array]] = []

    def ellipsoid(ahead: float, aside: float, above: float, half: tuple[float, float, float]) -> None:
        centre = ground + (ahead * forward + aside * left + above * up) * height[:, None]
        wide = np.stack([half[0] * girth, half[1] * girth, np.full(count, half[2])]) * height
        axes = np.stack([forward, left, np.broadcast_to(up, forward.shape)], axis=3) * wide.T[:, None, :]
        parts.append((centre, axes))

    def limb(aside: float, above: float, length: float, thick: float, angle: Array) -> None:
        joint = ground + (aside * left + above * up) * height[:, None]
        cos, sin = np.cos(angle)[..., None], np.sin(angle)[..., None]
        along = sin * forward - cos * up
        across = cos * forward + sin * up
        half = np.stack([thick * girth, thick * girth, np.full(count, length / 2)]) * height
        axes = np.stack([across, left, -along], axis=3) * half.T[:, None, :]
        parts.append((joint + along * (length / 2 * height)[:, None], axes))

    ellipsoid(0.015, 0.0, 0.932, (0.051, 0.042, 0.068))
    ellipsoid(0.0, 0.0, 0.69, (0.065, 0.115, 0.19))
    ellipsoid(0.0, 0.0, 0.51, (0.06, 0.09, 0.1))
    limb(0.05, 0.51, 0.51, 0.045, swing)
    limb(-0.05, 0.51, 0.51, 0.045, -swing)
    limb(0.13, 0.82, 0.42, 0.026, -0.8 * swing)
    limb(-0.13, 0.82, 0.42, 0.026, 0.8 * swing)
    centres = np.concatenate([centre for centre, _ in parts], axis=1)
    axes = np.concatenate([axis for _, axis in parts], axis=1)
    return centres, axes, np.tile(np.arange(count), len(parts))
