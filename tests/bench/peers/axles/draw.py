"""Draws studies of axles that were measured with known errors: `python draw.py --out DIR --kind tolerances-friction --count 12`.

Beside each folder NAME stands NAME.truth.json, which nothing but `judge.py` may open. `--kind all` draws every kind, `--kind calibration`
one cause or none near what can be seen, on tolerances of random size.
"""

import argparse
import json
import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from bound import bound
from folder import Deck, write_study
from geometry import KINDS, direction
from parts import Bushing, rotation
from statics import NoEquilibrium, Reality, World

LARGE = dict(hardpoints=0.3, load_gain=0.005, preload=0.003)
SMALL = dict(hardpoints=0.1, load_gain=0.002)

# What is planted, the tolerances, and how it is measured.
CONDITIONS = {
    "clean": ((), {}, {}),
    "noise-half": ((), {}, dict(declared=0.5)),
    "noise-double": ((), {}, dict(declared=2.0)),
    "noise-undeclared": ((), {}, dict(declared=0.0)),
    "tolerances": ((), LARGE, {}),
    "tolerances-small": ((), SMALL, {}),
    "tolerances-stated": ((), LARGE, dict(stated=True)),
    "pose-noise": ((), {}, dict(pose=0.05)),
    "heavy-tails": ((), {}, dict(tails=3.0)),
    "outliers": ((), {}, dict(outliers=6)),
    "loads": ((), {}, dict(loads=0.003)),
    "alignment": ((), {}, dict(alignment=0.25)),
    "mount": ((), {}, dict(mount=0.03)),
    "frame": ((), {}, dict(frame=0.03)),
    "frame-walk": ((), {}, dict(frame_walk=0.02)),
    "mark-place": ((), {}, dict(misplaced=0.8)),
    "mark-loose": ((), {}, dict(loose=0.8)),
    "tolerances-friction": (("dry-friction",), LARGE, {}),
    "play": (("free-play",), {}, {}),
    "tolerances-play": (("free-play",), LARGE, {}),
    "tolerances-tie-rod": (("link-compliance",), LARGE, {}),
    "tolerances-progressive": (("progressive-stiffness",), LARGE, {}),
    "tolerances-hardpoint": (("hardpoint-error",), LARGE, {}),
    "hardpoint": (("hardpoint-error",), {}, {}),
    "part": (("part",), {}, {}),
    "load-gain": (("load-gain",), {}, {}),
    "spring-rate": (("element-parameter",), {}, {}),
    "load-point": (("load-point-error",), {}, {}),
    "bushing-orientation": (("bushing-orientation",), {}, {}),
    "friction-tie-rod": (("dry-friction", "link-compliance"), {}, {}),
    "progressive-tie-rod": (("progressive-stiffness", "link-compliance"), {}, {}),
    "hardpoint-friction": (("hardpoint-error", "dry-friction"), {}, {}),
    "tolerances-friction-tie-rod": (("dry-friction", "link-compliance"), LARGE, {}),
    "tolerances-hardpoint-friction": (("hardpoint-error", "dry-friction"), LARGE, {}),
    "calibration": (None, None, {}),
    "rubber": (("rubber",), {}, {}),
    "tolerances-rubber": (("rubber",), LARGE, {}),
    "frictions": (("frictions",), {}, {}),
    "tolerances-frictions": (("frictions",), LARGE, {}),
}
# Not among all kinds: these plant a cause in every bushing that works.
BY_NAME = ("calibration", "rubber", "tolerances-rubber", "frictions", "tolerances-frictions")
SIGMA_WHEEL = (0.02, 0.005)


def condition(kind):
    """What is planted, the tolerances, and how it is measured: of a kind, or of several at once, joined with +."""
    planted, tolerances, how = (), {}, {}
    for name in kind.split("+"):
        more = CONDITIONS[name]
        if more[0] is None:
            return more
        planted, tolerances, how = planted + more[0], {**tolerances, **more[1]}, {**how, **more[2]}
    return planted, tolerances, how


class TooFar(Exception):
    """A drawn axle that does not stand, or a cause that does nothing on it."""


def tolerances_of(axle, sizes, rng):
    """A reality in which everything is a little off."""
    reality = Reality()
    for name in axle.hardpoints():
        reality.points[name] = sizes.get("hardpoints", 0.0) * rng.normal(size=3)
    matrix = np.eye(len(axle.loads))
    angle = np.radians(sizes.get("load_direction_deg", 0.0))
    for k in range(len(axle.loads)):
        matrix[:, k] += angle * rng.normal(size=len(axle.loads)) * (np.arange(len(axle.loads)) != k)
        matrix[k, k] *= 1 + sizes.get("load_gain", 0.0) * rng.normal()
    reality.load_matrix = matrix
    reality.springs = {"COIL": (1.0, 1 + sizes.get("preload", 0.0) * rng.normal())}
    return reality


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


class Causes:
    """Plants causes in a reality and says in the words of a study what they are. `near` draws sizes around what can be seen."""

    def __init__(self, axle, deck, ranges, rng, near):
        self.axle, self.deck, self.ranges, self.rng, self.near = axle, deck, ranges, rng, near
        self.taken = set()

    def component(self):
        """A translation of a bushing that is sought, the likelier the more it works."""
        work, keys = [], []
        for c in self.axle.of(Bushing):
            low, high = self.ranges[c.name]
            for axis in range(3):
                if c.sought and high[axis] - low[axis] > 0.3 and (c.name, axis) not in self.taken:
                    keys.append((c, axis))
                    work.append(c.K[axis] * (high[axis] - low[axis]) ** 2)
        if not keys:
            raise TooFar("no bushing works")
        c, axis = keys[self.rng.choice(len(keys), p=np.array(work) / sum(work))]
        self.taken.add((c.name, axis))
        low, high = self.ranges[c.name]
        return c, axis, high[axis] - low[axis], max(abs(low[axis]), abs(high[axis]))

    def plant(self, cause, reality):
        """What is planted; several causes where one word stands for them."""
        planted = getattr(self, cause.replace("-", "_"))(reality)
        return planted if isinstance(planted, list) else [planted]

    def everywhere(self):
        """Every translation of a bushing that is sought and works at all."""
        for c in self.axle.of(Bushing):
            low, high = self.ranges[c.name]
            for axis in range(3):
                if c.sought and high[axis] - low[axis] > 0.02:
                    yield c, axis, high[axis] - low[axis], max(abs(low[axis]), abs(high[axis]))

    def rubber(self, reality):
        """Rubber is progressive along every axis."""
        return [self.progressive(reality, c, axis, most, self.rng.uniform(0.05, 0.25)) for c, axis, _, most in self.everywhere()]

    def frictions(self, reality):
        """A little friction along every axis."""
        return [self.rubbing(reality, c, axis, width, self.rng.uniform(0.005, 0.02)) for c, axis, width, _ in self.everywhere()]

    def hardpoint_error(self, reality):
        seen = [p for p in self.axle.hardpoints() if p not in ("FOOT", "SEAT", "LOW", "TOP")]
        point = seen[self.rng.integers(len(seen))]
        shift = (log_uniform(self.rng, 0.8, 3.5) if self.near else 2.0) * direction(self.rng)
        reality.points[point] = reality.points.get(point, 0.0) + shift
        return dict(cause="hardpoint-error", form="point", addresses=self.deck.meeting(point), shift_mm=list(np.round(shift, 4)), point=point)

    def part(self, reality):
        """A ball joint of one part is elsewhere."""
        name = [c.name for c in self.axle.connections if type(c).__name__ == "Ball"]
        name = name[self.rng.integers(len(name))]
        shift = 2.0 * direction(self.rng)
        reality.sides[name, "i"] = shift
        body = next(c.i for c in self.axle.connections if c.name == name)
        own = self.deck.R[body].T @ shift
        sides = [f"MARKER/{self.deck.sides[name, s]}" for s in "ij"]
        return dict(cause="hardpoint-error", form="part", addresses=sides, shift_mm=list(np.round(own, 4)))

    def dry_friction(self, reality):
        c, axis, width, _ = self.component()
        share = log_uniform(self.rng, 0.0005, 0.02) if self.near else self.rng.uniform(0.015, 0.04)
        return self.rubbing(reality, c, axis, width, share)

    def rubbing(self, reality, c, axis, width, share):
        force = float(share * c.K[axis] * width)
        reach = width * self.rng.uniform(0.01, 0.04)
        reality.friction[c.name, axis] = (force, reach)
        return dict(cause="dry-friction", addresses=[f"{self.deck.address[c.name]}.K.{axis + 1}"], force=force, slips_half_at_mm=reach)

    def progressive_stiffness(self, reality):
        c, axis, _, most = self.component()
        more = log_uniform(self.rng, 0.005, 0.2) if self.near else self.rng.uniform(0.2, 0.4)
        return self.progressive(reality, c, axis, most, more)

    def progressive(self, reality, c, axis, most, more):
        length = most / np.sqrt(6 * more)
        reality.growing[c.name, axis] = length
        return dict(cause="progressive-stiffness", addresses=[f"{self.deck.address[c.name]}.K.{axis + 1}"], cubic=float(c.K[axis] / (6 * length**2)))

    def link_compliance(self, reality):
        links = list(self.axle.links)
        link = links[self.rng.integers(len(links))]
        inner, outer, ball = self.axle.links[link]
        stiffness = log_uniform(self.rng, 1.2e4, 1.5e5) if self.near else self.rng.uniform(6e3, 1.2e4)
        reality.compliance[ball] = (link, inner, 1 / stiffness)
        return dict(cause="link-compliance", addresses=[f"PART/{self.deck.part[link]}"], stiffness=stiffness)

    def free_play(self, reality):
        links = list(self.axle.links)
        link = links[self.rng.integers(len(links))]
        inner, outer, ball = self.axle.links[link]
        half = self.rng.uniform(0.1, 0.25)
        reality.play = (ball, link, inner, half, 100.0)
        return dict(cause="free-play", addresses=[f"PART/{self.deck.part[link]}"], play=2 * half)

    def load_gain(self, reality):
        k = int(self.rng.integers(len(self.axle.loads)))
        gain = 1 + (1 if self.rng.random() < 0.5 else -1) * (log_uniform(self.rng, 0.005, 0.05) if self.near else self.rng.uniform(0.04, 0.07))
        reality.load_matrix[:, k] *= gain
        return dict(cause="load-gain", addresses=[self.deck.address[self.axle.loads[k].column]], gain=float(gain))

    def element_parameter(self, reality):
        factor = 1 + (1 if self.rng.random() < 0.5 else -1) * self.rng.uniform(0.08, 0.15)
        rate, force = reality.springs["COIL"]
        reality.springs["COIL"] = (rate * factor, force)
        return dict(cause="element-parameter", addresses=[self.deck.address["COIL"] + ".K"], factor=float(factor))

    def load_point_error(self, reality):
        shift = self.rng.uniform(12, 20) * direction(self.rng)
        reality.load_points["CP"] = shift
        return dict(cause="load-point-error", addresses=[f"MARKER/{self.deck.sides['load', 'CP']}"], shift_mm=list(np.round(shift, 3)))

    def bushing_orientation(self, reality):
        c, _, _, _ = self.component()
        angle = (1 if self.rng.random() < 0.5 else -1) * self.rng.uniform(10, 20)
        reality.tilts[c.name] = rotation(c.axes[:, self.rng.integers(2)], np.radians(angle))
        return dict(cause="bushing-orientation", addresses=[self.deck.address[c.name]], angle_deg=float(angle))


def measure(world, poses, rng, how, sigma):
    """Marks as they are read; which are wrong."""
    axle = world.axle
    places = {n: b.marks + how.get("marks_on_parts", 0.0) * rng.normal(size=b.marks.shape) for n, b in axle.bodies.items()}
    marks = world.marks(poses, places)
    shift = how.get("pose", 0.0) * rng.normal(size=marks.shape[:2] + (3,))
    turn = how.get("pose", 0.0) / 200.0 * rng.normal(size=marks.shape[:2] + (3,))
    centre = marks.mean(2, keepdims=True)
    marks = marks + shift[:, :, None] + np.cross(np.broadcast_to(turn[:, :, None], marks.shape), marks - centre)
    draw = rng.standard_t(how["tails"], marks.shape) if "tails" in how else rng.normal(size=marks.shape)
    marks += sigma * draw
    wrong, flat = [], rng.permutation(np.prod(marks.shape[:3]))[: how.get("outliers", 0)]
    for k in flat:
        case, part, mark = np.unravel_index(k, marks.shape[:3])
        marks[case, part, mark] += 2.0 * direction(rng)
        wrong.append(f"case {case + 1} {world.names[part]} {mark + 1}")
    return marks, wrong


def moved(world, poses, marks, cases, rng, how):
    """Moves all marks together: of all cases alike, of each by itself, or on from the case before; and one mark on its part. Tells what is a cause."""
    count = len(marks)
    if size := how.get("mount"):
        # Along each load and about the axis that follows, by so much per 1000 N.
        for load, values in zip(world.axle.loads, np.asarray(cases).T / 1000.0):
            along = size * values[:, None, None, None] * np.asarray(load.direction)
            about = size / 700.0 * values[:, None, None, None] * np.roll(load.direction, 1)
            marks += along + np.cross(np.broadcast_to(about, marks.shape), marks - marks.mean((0, 1, 2)))
    if size := how.get("alignment"):
        shift, turn = size * rng.normal(size=(2, 3)) / np.array([1.0, 700.0])[:, None]
        marks += shift + np.cross(turn, marks - marks.mean((0, 1, 2)))
    for size, followed in ((how.get("frame", 0.0), False), (how.get("frame_walk", 0.0), True)):
        if size:
            steps = size * rng.normal(size=(2, count, 1, 1, 3)) / np.array([1.0, 700.0])[:, None, None, None, None]
            shift, turn = np.cumsum(steps, axis=1) if followed else steps
            marks += shift + np.cross(np.broadcast_to(turn, marks.shape), marks - marks.mean((1, 2), keepdims=True))
    size = how.get("misplaced") or how.get("loose")
    if not size:
        return []
    part, mark = int(rng.integers(marks.shape[1])), int(rng.integers(marks.shape[2]))
    first = int(count * rng.uniform(0.2, 0.8)) if how.get("loose") else 0
    places = {n: b.marks.copy() for n, b in world.axle.bodies.items()}
    places[world.names[part]][mark] += size * direction(rng)
    marks[first:] += (world.marks(poses, places) - world.marks(poses))[first:]
    return [dict(cause="mark-place", addresses=[f"{world.names[part]} {mark + 1}"])]


def wheel(world, poses, rng):
    """Wheel centre, camber (top outboard is positive) and steer (right-handed about z)."""
    body, centre, spin = world.axle.wheel
    place = world.at(body, world.axle.points[centre], *poses)
    now = world.along(body, spin, poses[1])
    camber = np.degrees(np.arcsin(spin[2]) - np.arcsin(now[:, 2]))
    steer = np.degrees(np.arctan2(now[:, 1], now[:, 0]) - np.arctan2(spin[1], spin[0]))
    steer = (steer + 180) % 360 - 180
    read = np.column_stack([place, camber, steer])
    return read + rng.normal(size=read.shape) * np.array([SIGMA_WHEEL[0]] * 3 + [SIGMA_WHEEL[1]] * 2)


def study(path, kind, axle_name, seed, instruments, with_bound=False, cases=None):
    """One study: folder and truth. The axle, its tolerances and the noise depend on the seed alone; a seed whose axle does not stand
    draws again."""
    for attempt in range(20):
        streams = [np.random.default_rng([seed, attempt, k, sorted(KINDS).index(axle_name)]) for k in range(4)]
        try:
            return drawn(path, kind, axle_name, seed, instruments, streams, with_bound, cases)
        except (NoEquilibrium, TooFar):
            continue
    raise SystemExit(f"no axle of kind {axle_name} stands with seed {seed}")


def drawn(path, kind, axle_name, seed, instruments, streams, with_bound, cases):
    of_axle, of_background, of_causes, of_noise = streams
    axle = KINDS[axle_name](of_axle)
    if cases:
        axle.cases = [axle.cases[k] for k in np.linspace(0, len(axle.cases) - 1, cases).round().astype(int)]
    sigma = float(of_axle.choice([0.02, 0.03, 0.05]))
    deck = Deck(axle, unknown=(1e4, 1e4))
    nominal = World(axle)
    design = nominal.sweep()
    planted, sizes, how = condition(kind)
    near = planted is None
    if near:
        size = log_uniform(of_background, 0.03, 0.4)
        sizes = dict(hardpoints=size, load_gain=size / 60, load_direction_deg=size / 5, preload=size / 100)
        how = dict(marks_on_parts=size / 30, pose=log_uniform(of_background, 0.001, 0.02))
        classes = ["hardpoint-error", "dry-friction", "link-compliance", "progressive-stiffness", "load-gain", None, None]
        drawn_class = classes[of_causes.integers(len(classes))]
        planted = (drawn_class,) if drawn_class else ()
    background = tolerances_of(axle, sizes, of_background)
    reality = tolerances_of(axle, {}, np.random.default_rng(0))
    reality.points = dict(background.points)
    reality.load_matrix, reality.springs = background.load_matrix.copy(), dict(background.springs)
    # The table states what was asked for; a multi-axis rig holds a load of zero no better than another.
    cases = np.array(axle.cases, float)
    scatter = np.random.default_rng([seed, 5]).normal(size=cases.shape)
    reality.load_errors = background.load_errors = how.get("loads", 0.0) * np.abs(cases).max(0) * scatter
    causes = Causes(axle, deck, nominal.ranges(design), of_causes, near)
    truth = [said for cause in planted for said in causes.plant(cause, reality)]
    world, without = World(axle, reality), World(axle, background)
    poses = world.sweep()
    exact = nominal.marks(design)
    off = without.marks(without.sweep()) if sizes else exact
    marks, wrong = measure(world, poses, of_noise, how, sigma)
    truth += moved(world, poses, marks, cases, np.random.default_rng([seed, 6]), how)
    truth += [dict(cause="mark-outlier", addresses=[address]) for address in wrong]
    declared = how.get("declared", 1.0)
    measured = dict(sigma=sigma * declared, sigma_wheel=SIGMA_WHEEL)
    if "marks" in instruments:
        measured["marks"] = marks
    if "wheel" in instruments:
        measured["wheel"] = wheel(world, poses, of_noise)
    if how.get("stated"):
        measured["tolerances"] = {name: size for name, size in sizes.items() if name in ("hardpoints", "load_gain", "load_direction_deg")}
    write_study(path, deck, measured)
    stiffness = {}
    for c in axle.of(Bushing):
        if c.sought:
            for k in range(3):
                stiffness[f"{deck.address[c.name]}.K.{k + 1}"] = float(c.K[k])
                stiffness[f"{deck.address[c.name]}.KT.{k + 1}"] = float(c.KT[k])
    rms = lambda a, b: float(np.sqrt(np.mean((a - b) ** 2)))
    said = dict(kind=kind, axle=axle_name, seed=seed, causes=truth, sigma_mm=sigma, declared_sigma_mm=sigma * declared, tolerances=sizes, measuring=how,
                effect_shift_mm_rms=rms(world.marks(poses), off), total_shift_mm_rms=rms(world.marks(poses), exact), stiffness=stiffness)
    if with_bound:
        said["least_sd_of_ln"] = bound(axle, deck, reality, sizes, how, sigma)
    with open(path + ".truth.json", "w") as file:
        json.dump(said, file, indent=1)
    return said


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", required=True)
    parser.add_argument("--kind", default="all", help=", ".join(CONDITIONS) + "; several with commas, or all; joined with + at once")
    parser.add_argument("--axle", default="mcpherson", help=", ".join(KINDS) + "; several with commas take turns, or all")
    parser.add_argument("--count", type=int, default=1, help="of each kind")
    parser.add_argument("--seed", type=int, default=1, help="the first one")
    parser.add_argument("--instruments", default="marks", help="marks, wheel or marks,wheel")
    parser.add_argument("--cases", type=int, help="so few of the 31 load cases, in their order")
    parser.add_argument("--bound", action="store_true", help="also the least standard deviations the marks allow, for the widths of intervals")
    options = parser.parse_args()
    kinds = [k for k in CONDITIONS if k not in BY_NAME] if options.kind == "all" else options.kind.split(",")
    axles = list(KINDS) if options.axle == "all" else options.axle.split(",")
    unknown = [k for kind in kinds for k in kind.split("+") if k not in CONDITIONS] + [a for a in axles if a not in KINDS]
    if unknown:
        parser.error(f"unknown: {', '.join(unknown)}")
    for kind in kinds:
        for k in range(options.count):
            seed, axle = options.seed + k, axles[k % len(axles)]
            name = f"{kind}-{axle}-{seed}"
            said = study(os.path.join(options.out, name), kind, axle, seed, options.instruments.split(","), options.bound, options.cases)
            causes = ", ".join(c["cause"] + " " + c["addresses"][0] for c in said["causes"][:2]) or "nothing"
            print(f"{name}: {causes}; {said['effect_shift_mm_rms']:.3f} mm rms of {said['total_shift_mm_rms']:.3f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
