"""Four-bars (IFToMM benchmark A02) and a quarter car side by side by admire and by Exudyn: time against the error at the end. See README.md.

The rods lie in one line ten times in ten seconds. All stay parallel, so that `J q'' = m g sin q` is the exact answer.
"""

import argparse
import csv
import functools
import os
import resource
import subprocess
import tempfile
import time

import exudyn as exu
import numpy as np
from exudyn.utilities import (CartesianSpringDamper, GenericJoint, MarkerBodyRigid, RigidBodyInertia, RigidBodySpringDamper, SensorBody,
                              SphericalJoint, SpringDamper)

THICK = 0.1
ACROSS, ALONG = 1 / 12 + THICK**2 / 16, THICK**2 / 8
END = 10.0


@functools.cache
def exact(windows):
    """Place of the upper end of the first rod at the end."""
    inertia = (windows + 1) * (1 / 3 + THICK**2 / 16) + windows
    moment = 9.81 * ((windows + 1) / 2 + windows)
    rate = lambda s: np.array([s[1], moment * np.sin(s[0]) / inertia])
    s, count = np.array([0.0, 1.0]), 40000
    h = END / count
    for _ in range(count):
        a = rate(s)
        b = rate(s + h / 2 * a)
        c = rate(s + h / 2 * b)
        d = rate(s + h * c)
        s = s + h / 6 * (a + 2 * b + 2 * c + d)
    return np.array([np.sin(s[0]), np.cos(s[0])])


def write_deck(folder, windows, error, end=END):
    lines = [
        "four-bars",
        "UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND",
        "PART/1, GROUND",
        "ACCGRAV/JGRAV=-9.81",
    ]
    joints = []

    def rod(part, place, upright):
        d = (0, 1) if upright else (1, 0)
        ip = (ACROSS, ALONG, ACROSS) if upright else (ALONG, ACROSS, ACROSS)
        moving = "VX=0.5, WZ=-1" if upright else "VX=1"
        lines.append(f"PART/{part}, MASS=1, CM={part}00, IP={ip[0]},{ip[1]},{ip[2]}, QG={place[0]},{place[1]},0, {moving}")
        for k, share in ((0, 0.5), (1, 0), (2, 1)):
            lines.append(f"MARKER/{part}0{k}, PART={part}, QP={share * d[0]},{share * d[1]},0")

    for k in range(windows + 1):
        rod(2 + k, (k, 0), True)
        lines.append(f"MARKER/{9_000_000 + k}, PART=1, QP={k},0,0")
        joints.append((f"{2 + k}01", 9_000_000 + k))
    for k in range(windows):
        part = windows + 3 + k
        rod(part, (k, 1), False)
        joints += [(f"{part}01", f"{2 + k}02"), (f"{part}02", f"{3 + k}02")]
    for k, (i, j) in enumerate(joints):
        lines.append(f"JOINT/{k + 1}, REVOLUTE, I={i}, J={j}")
    lines += [f"INTEGRATOR/GSTIFF, ERROR={error}, HMAX=0.2", "RESULTS/FORMATTED, XRF", "END"]
    with open(os.path.join(folder, "bars.adm"), "w") as file:
        file.write("\n".join(lines) + "\n")
    with open(os.path.join(folder, "bars.acf"), "w") as file:
        file.write(f"bars\nbars\nSIMULATE/DYNAMIC, END={end}, STEPS=1\nSTOP\n")


def solved(admire, write):
    """Processor seconds of the whole process, reading and writing included, and the rows of its table."""
    with tempfile.TemporaryDirectory() as folder:
        write(folder)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [admire, "solve", "bars.acf", "--csv", "bars.csv"]
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        with open(os.path.join(folder, "bars.csv"), newline="") as file:
            rows = list(csv.reader(file))
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, rows


def ours(admire, windows, error):
    """Processor seconds, and the error at the end."""
    seconds, rows = solved(admire, lambda folder: write_deck(folder, windows, error))
    entity = f"PART_{windows + 3}_XFORM"
    at = [k for k, name in enumerate(rows[0]) if name.startswith(entity)][:2]
    found = np.array([float(rows[-1][k]) for k in at])
    return seconds, np.abs(found - exact(windows)).max()


def theirs(windows, steps):
    """Processor seconds of SolveDynamic alone, and the error at the end."""
    system = exu.SystemContainer()
    mbs = system.AddSystem()
    ground = mbs.CreateGround()

    def rod(place, upright):
        d = np.array([0, 1, 0] if upright else [1, 0, 0])
        tensor = np.diag([ACROSS, ALONG, ACROSS] if upright else [ALONG, ACROSS, ACROSS])
        return mbs.CreateRigidBody(
            inertia=RigidBodyInertia(mass=1, com=[0, 0, 0], inertiaTensor=tensor),
            referencePosition=list(np.array([*place, 0]) + d / 2),
            initialVelocity=[0.5, 0, 0] if upright else [1, 0, 0],
            initialAngularVelocity=[0, 0, -1] if upright else [0, 0, 0],
            gravity=[0, -9.81, 0],
        )

    upright = [rod((k, 0), True) for k in range(windows + 1)]
    level = [rod((k, 1), False) for k in range(windows)]
    # Exudyn takes no redundant equations: each window closes with the two of its plane.
    turning = lambda a, b, p: mbs.CreateRevoluteJoint(bodyNumbers=[a, b], position=p, axis=[0, 0, 1], useGlobalFrame=True, show=False)
    closing = lambda a, b, p: mbs.CreateGenericJoint(
        bodyNumbers=[a, b], position=p, constrainedAxes=[1, 1, 0, 0, 0, 0], useGlobalFrame=True, show=False
    )
    for k, body in enumerate(upright):
        turning(ground, body, [k, 0, 0])
    for k, body in enumerate(level):
        turning(upright[k], body, [k, 1, 0])
        closing(body, upright[k + 1], [k + 1, 1, 0])
    place = exu.OutputVariableType.Position
    sensor = mbs.AddSensor(
        SensorBody(bodyNumber=upright[0], localPosition=[0, 0.5, 0], outputVariableType=place, writeToFile=False, storeInternal=True)
    )
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = END
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = END
    if windows > 5:
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    start = time.process_time()
    try:
        mbs.SolveDynamic(settings)
    except exu.SolverError:
        return time.process_time() - start, np.inf
    seconds = time.process_time() - start
    found = np.array(mbs.GetSensorStoredData(sensor))[-1][1:3]
    return seconds, np.abs(found - exact(windows)).max()


# A quarter car on a shaker: chassis on a rail, wheel carrier, two arms on two bushings each, ball joints, tie rod and strut as springs, tyre.
# The road is a mass so heavy that nothing changes its swing, at the wheel's own frequency.
CHASSIS, CARRIER, LOWER, UPPER = 400.0, 40.0, 5.0, 3.0
FALL = 0.5
INNER = {"lower": [(0.15, 0.4, 0.2), (-0.15, 0.4, 0.2)], "upper": [(0.1, 0.45, 0.45), (-0.1, 0.45, 0.45)]}
OUTER = {"lower": (0.0, 0.75, 0.18), "upper": (-0.02, 0.7, 0.47)}
RUBBER = dict(K=(8e6, 8e6, 1e6), C=(800.0, 800.0, 100.0), KT=(60.0, 60.0, 60.0), CT=(0.5, 0.5, 0.5))
TIE = ((-0.12, 0.42, 0.22), (-0.12, 0.74, 0.21), 5e6, 500.0)
STRUT = ((0.0, 0.5, 0.6), (0.0, 0.6, 0.19), 3e4, 1500.0)
PRELOAD = {TIE: 0.0, STRUT: 0.2}  # what the spring is longer without load
WHEEL, TYRE, TYRE_DAMPING = (0.0, 0.8, 0.3), 2e5, 200.0
ROAD, SWING, RATE = 1e6, 0.004, 2 * np.pi * 10
CAR_END = 5.0


def inertia_of(mass, length):
    return (mass * length**2 / 12,) * 3


CAR = {
    "chassis": (CHASSIS, (0.0, 0.0, 0.6), (50.0, 80.0, 90.0)),
    "carrier": (CARRIER, WHEEL, (1.0, 1.6, 1.0)),
    "lower": (LOWER, (0.0, 0.6, 0.19), inertia_of(LOWER, 0.4)),
    "upper": (UPPER, (0.0, 0.6, 0.46), inertia_of(UPPER, 0.3)),
    "road": (ROAD, (0.0, 0.8, -0.5), (1e6, 1e6, 1e6)),
}
BED = ((0.0, 0.8, -1.5), CAR["road"][1], ROAD * RATE**2, 0.0)
PRELOAD[BED] = 9.81 / RATE**2
VELOCITY = {"road": SWING * RATE}


def scaling(admire):
    """What a body costs: processor seconds of half a second of motion, no singular position in it, beside those of its first tenth."""
    print("| bodies | admire, s | begins, s | a body, ms |\n|---|---|---|---|", flush=True)
    for windows in (25, 100, 400, 1000):
        bodies = 2 * windows + 1
        begins, whole = (min(solved(admire, lambda folder, end=end: write_deck(folder, windows, "1E-5", end))[0] for _ in range(3)) for end in (0.05, 0.5))
        print(f"| {bodies} | {whole:.2f} | {begins:.2f} | {1e3 * (whole - begins) / bodies:.3f} |", flush=True)


def write_car(folder, error):
    place = lambda p: ",".join(str(x) for x in p)
    lines = ["quarter car", "UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND", "PART/1, GROUND", "MARKER/1, PART=1", "ACCGRAV/KGRAV=-9.81"]
    number = {name: 2 + k for k, name in enumerate(CAR)}
    for name, (mass, centre, moments) in CAR.items():
        part = number[name]
        lines += [f"PART/{part}, MASS={mass}, CM={part}00, IP={place(moments)}, VZ={VELOCITY.get(name, -FALL)}", f"MARKER/{part}00, PART={part}, QP={place(centre)}"]
    ids = iter(range(1000, 2000))

    def marker(part, point):
        lines.append(f"MARKER/{(m := next(ids))}, PART={part}, QP={place(point)}")
        return m

    def spring(k, one, two, what):
        p, q, stiffness, damping = what
        length = np.linalg.norm(np.subtract(p, q)) + PRELOAD[what]
        i, j = marker(one, p), marker(two, q)
        lines.append(f"SPRINGDAMPER/{k}, TRANSLATIONAL, I={i}, J={j}, K={stiffness}, C={damping}, LENGTH={length:.17g}")

    lines.append(f"JOINT/1, TRANSLATIONAL, I={number['chassis']}00, J={marker(1, CAR['chassis'][1])}")
    bushing = ", ".join(f"{key}={place(values)}" for key, values in RUBBER.items())
    for k, arm in enumerate(("lower", "upper")):
        for m, point in enumerate(INNER[arm]):
            lines.append(f"BUSHING/{2 * k + m + 1}, I={marker(number[arm], point)}, J={marker(number['chassis'], point)}, {bushing}")
        i, j = marker(number[arm], OUTER[arm]), marker(number["carrier"], OUTER[arm])
        lines.append(f"JOINT/{2 + k}, SPHERICAL, I={i}, J={j}")
    spring(1, number["chassis"], number["carrier"], TIE)
    spring(2, number["chassis"], number["lower"], STRUT)
    lines.append(f"JOINT/4, TRANSLATIONAL, I={number['road']}00, J={marker(1, CAR['road'][1])}")
    spring(3, 1, number["road"], BED)
    wheel, road = f"{number['carrier']}00", marker(number["road"], WHEEL)
    lines += [f"MARKER/2, PART={number['road']}, FLOATING", f"VFORCE/1, I={wheel}, JFLOAT=2, RM=1"]
    lines.append(f", FX=0\\FY=0\\FZ=-{TYRE}*DZ({wheel},{road})-{TYRE_DAMPING}*VZ({wheel},{road})")
    lines += [f"INTEGRATOR/GSTIFF, ERROR={error}, HMAX=0.2", "RESULTS/FORMATTED, XRF", "END"]
    with open(os.path.join(folder, "bars.adm"), "w") as file:
        file.write("\n".join(lines) + "\n")
    with open(os.path.join(folder, "bars.acf"), "w") as file:
        file.write(f"bars\nbars\nSIMULATE/DYNAMIC, END={CAR_END}, STEPS=1\nSTOP\n")


def our_car(admire, error):
    """Processor seconds of the whole process, and where chassis and carrier are at the end."""
    seconds, rows = solved(admire, lambda folder: write_car(folder, error))
    column = lambda entity, axis: float(rows[-1][next(k for k, n in enumerate(rows[0]) if n.startswith(entity) and n.split(".")[-1].split(" ")[0] == axis)])
    return seconds, np.array([column("PART_2_XFORM", "Z"), *(column("PART_3_XFORM", axis) for axis in "XYZ")])


def their_car(steps):
    """Processor seconds of SolveDynamic alone, and where chassis and carrier are at the end."""
    system = exu.SystemContainer()
    mbs = system.AddSystem()
    ground = mbs.CreateGround()
    bodies = {
        name: mbs.CreateRigidBody(
            inertia=RigidBodyInertia(mass=mass, com=[0, 0, 0], inertiaTensor=np.diag(moments)),
            referencePosition=list(centre),
            initialVelocity=[0, 0, VELOCITY.get(name, -FALL)],
            gravity=[0, 0, -9.81],
        )
        for name, (mass, centre, moments) in CAR.items()
    }
    rigid = lambda body, point: mbs.AddMarker(MarkerBodyRigid(bodyNumber=bodies[body], localPosition=list(np.subtract(point, CAR[body][1]))))
    at = lambda point: mbs.AddMarker(MarkerBodyRigid(bodyNumber=ground, localPosition=list(point)))
    rail = [at(CAR["chassis"][1]), rigid("chassis", CAR["chassis"][1])]
    mbs.AddObject(GenericJoint(markerNumbers=rail, constrainedAxes=[1, 1, 0, 1, 1, 1]))
    stiffness, damping = (np.diag([*RUBBER[a], *RUBBER[b]]) for a, b in (("K", "KT"), ("C", "CT")))
    for arm in ("lower", "upper"):
        for point in INNER[arm]:
            ends = [rigid("chassis", point), rigid(arm, point)]
            mbs.AddObject(RigidBodySpringDamper(markerNumbers=ends, stiffness=stiffness, damping=damping))
        mbs.AddObject(SphericalJoint(markerNumbers=[rigid(arm, OUTER[arm]), rigid("carrier", OUTER[arm])]))
    for ends, what in ((("chassis", "carrier"), TIE), (("chassis", "lower"), STRUT)):
        p, q, k, c = what
        length = float(np.linalg.norm(np.subtract(p, q))) + PRELOAD[what]
        mbs.AddObject(SpringDamper(markerNumbers=[rigid(ends[0], p), rigid(ends[1], q)], referenceLength=length, stiffness=k, damping=c))
    bed = [at(CAR["road"][1]), rigid("road", CAR["road"][1])]
    mbs.AddObject(GenericJoint(markerNumbers=bed, constrainedAxes=[1, 1, 0, 1, 1, 1]))
    length = float(np.linalg.norm(np.subtract(BED[0], BED[1]))) + PRELOAD[BED]
    mbs.AddObject(SpringDamper(markerNumbers=[at(BED[0]), bed[1]], referenceLength=length, stiffness=BED[2], damping=BED[3]))
    tyre = [rigid("road", WHEEL), rigid("carrier", WHEEL)]
    mbs.AddObject(CartesianSpringDamper(markerNumbers=tyre, stiffness=[0, 0, TYRE], damping=[0, 0, TYRE_DAMPING]))
    place = exu.OutputVariableType.Position
    sensors = [mbs.AddSensor(SensorBody(bodyNumber=bodies[b], outputVariableType=place, writeToFile=False, storeInternal=True)) for b in ("chassis", "carrier")]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = CAR_END
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = CAR_END
    start = time.process_time()
    try:
        mbs.SolveDynamic(settings)
    except exu.SolverError:
        return time.process_time() - start, np.full(4, np.inf)
    seconds = time.process_time() - start
    chassis, carrier = (np.array(mbs.GetSensorStoredData(s))[-1][1:] for s in sensors)
    return seconds, np.array([chassis[2], *carrier])


def car_trials(admire):
    """Errors against the solution of the same program with the smallest steps, over the range of the heights, 0.05 m."""
    best, range_ = our_car(admire, "1E-9")[1], 0.05
    # PART origins start in the ground; bodies of the other program in their centres.
    print(f"  the two solutions differ by {np.abs(best[0] - their_best()[0] + CAR['chassis'][1][2]):.1e} m in the height of the chassis")

    def own(error):
        seconds, found = our_car(admire, error)
        return seconds, np.abs(found - best).max() / range_

    def other(steps):
        seconds, found = their_car(steps)
        return seconds, np.abs(found - their_best()).max() / range_

    return own, other


@functools.cache
def their_best():
    """Two solutions with small steps, extrapolated: the method is of second order."""
    coarse, fine = their_car(100_000)[1], their_car(200_000)[1]
    return fine + (fine - coarse) / 3


def fastest_within(limit, trials):
    """The least time with which the limit is kept: trials get finer, the first three that keep it are compared."""
    kept = []
    for name, run in trials:
        seconds, error = run()
        if error <= limit:
            kept.append((seconds, error, name))
            if len(kept) == 3:
                break
    return min(kept, default=None)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--admire", default="target/release/admire")
    parser.add_argument("--windows", default="2,40", help="bodies are twice as many and one more; none: -")
    parser.add_argument("--no-car", action="store_true", help="no quarter car")
    parser.add_argument("--scaling", action="store_true", help="what a body costs in rows of 51 to 2001, of admire alone")
    arguments = parser.parse_args()
    admire = os.path.abspath(arguments.admire)
    if arguments.scaling:
        scaling(admire)
        return
    models = [(str(2 * w + 1), functools.partial(ours, admire, w), functools.partial(theirs, w)) for w in map(int, filter(str.isdigit, arguments.windows.split(",")))]
    if not arguments.no_car:
        models.append(("quarter car", *car_trials(admire)))
    print("| bodies | error at the end | admire, s | ERROR | Exudyn, s | steps | ratio |\n|---|---|---|---|---|---|---|", flush=True)
    for name, own_run, other_run in models:
        for limit in (1e-3, 1e-5):
            errors = [f"{m}E-{k}" for k in range(2, 9) for m in (1, 0.3)]
            own = fastest_within(limit, [(e, lambda e=e: own_run(e)) for e in errors])
            counts = [int(200 * 1.5**k) for k in range(22)]
            other = fastest_within(limit, [(n, lambda n=n: other_run(n)) for n in counts])
            told = [f"{best[0]:.3f} ({best[1]:.1e}) | {best[2]}" if best else "not reached | -" for best in (own, other)]
            ratio = f"{other[0] / own[0]:.1f}" if own and other else "-"
            print(f"| {name} | {limit:.0e} | {told[0]} | {told[1]} | {ratio} |", flush=True)


if __name__ == "__main__":
    main()
