"""What an axle is made of. All places and axes are those of the design position, in ground axes: mm, N, kg, rad."""

from dataclasses import dataclass, field

import numpy as np

GROUND = "GROUND"


@dataclass
class Body:
    """A rigid part. Its own axes are ground's at design; `frame` is only how the deck writes it."""

    origin: np.ndarray
    mass: float
    centre: np.ndarray
    frame: tuple = (0.0, 0.0, 0.0)  # degrees, body-fixed 3-1-3
    marks: np.ndarray = None  # places of marks


@dataclass
class Ball:
    name: str
    i: str
    j: str
    at: str


@dataclass
class Universal:
    """Three translations locked, and the two cross axes stay perpendicular."""

    name: str
    i: str
    j: str
    at: str
    z_i: np.ndarray
    z_j: np.ndarray


@dataclass
class Cylinder:
    """`i` slides and turns on `j` along the line of two points of the car; each side has its own place on it."""

    name: str
    i: str
    j: str
    at: str  # of j, a point of the car
    line: tuple  # names of the two points that span the line
    reach: float  # where i's place is on the line, from `at`


@dataclass
class Bushing:
    name: str
    i: str
    j: str
    at: str
    axes: np.ndarray
    K: np.ndarray
    KT: np.ndarray  # N mm per radian
    sought: bool = True


@dataclass
class Spring:
    name: str
    i: str
    j: str
    at_i: str
    at_j: str
    K: float
    force: float
    length: float


@dataclass
class Load:
    """A force on a part in a direction of ground; `column` is its name in the load table."""

    column: str
    body: str
    at: str
    direction: np.ndarray


@dataclass
class Axle:
    kind: str
    points: dict
    bodies: dict
    connections: list
    loads: list
    wheel: tuple  # body, point of the wheel centre, unit spin axis (outboard)
    cases: list  # rows of loads in the order of `loads`
    links: dict = field(default_factory=dict)  # part with two joints -> (inner point, outer point, name of the outer ball)

    def of(self, cls):
        return [c for c in self.connections if isinstance(c, cls)]

    def hardpoints(self):
        """Points of the car at which parts are held."""
        held = []
        for c in self.connections:
            held += [c.at_i, c.at_j] if isinstance(c, Spring) else [c.at]
        return sorted(set(held), key=held.index)


def rotation(axis, angle):
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)


def frame_along(z, about=0.0):
    """Right-handed axes whose third one is `z`."""
    z = np.asarray(z, float) / np.linalg.norm(z)
    across = np.eye(3)[np.argmin(np.abs(z))]
    x = np.cross(across, z)
    x /= np.linalg.norm(x)
    axes = np.column_stack([x, np.cross(z, x), z])
    return axes @ rotation([0, 0, 1], about)


def euler313(R):
    """Degrees psi, theta, phi with R = Rz(psi) Rx(theta) Rz(phi)."""
    theta = np.arctan2(np.hypot(R[2, 0], R[2, 1]), R[2, 2])
    if np.sin(theta) < 1e-12:
        return np.degrees([np.arctan2(R[1, 0], R[0, 0]), 0.0 if R[2, 2] > 0 else np.pi, 0.0])
    return np.degrees([np.arctan2(R[0, 2], -R[1, 2]), theta, np.arctan2(R[2, 0], R[2, 1])])


def from313(degrees):
    a, b, c = np.radians(degrees)
    return rotation([0, 0, 1], a) @ rotation([1, 0, 0], b) @ rotation([0, 0, 1], c)
