"""Four-bars side by side (IFToMM benchmark A02) by admire and by Exudyn: time against the error at the end. See README.md.

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
from exudyn.utilities import RigidBodyInertia, SensorBody

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


def write_deck(folder, windows, error):
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
        lines.append(f"MARKER/{10 + k}, PART=1, QP={k},0,0")
        joints.append((f"{2 + k}01", 10 + k))
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
        file.write(f"bars\nbars\nSIMULATE/DYNAMIC, END={END}, STEPS=1\nSTOP\n")


def ours(admire, windows, error):
    """Processor seconds of the whole process, reading and writing included, and the error at the end."""
    with tempfile.TemporaryDirectory() as folder:
        write_deck(folder, windows, error)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [admire, "solve", "bars.acf", "--csv", "bars.csv"]
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        with open(os.path.join(folder, "bars.csv"), newline="") as file:
            rows = list(csv.reader(file))
    entity = f"PART_{windows + 3}_XFORM"
    at = [k for k, name in enumerate(rows[0]) if name.startswith(entity)][:2]
    found = np.array([float(rows[-1][k]) for k in at])
    seconds = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
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
    mbs.SolveDynamic(settings)
    seconds = time.process_time() - start
    found = np.array(mbs.GetSensorStoredData(sensor))[-1][1:3]
    return seconds, np.abs(found - exact(windows)).max()


def first_within(limit, trials):
    for name, run in trials:
        seconds, error = run()
        if error <= limit:
            return seconds, error, name
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--admire", default="target/release/admire")
    parser.add_argument("--windows", default="2,40", help="bodies are twice as many and one more")
    arguments = parser.parse_args()
    admire = os.path.abspath(arguments.admire)
    print("| bodies | error at the end | admire, s | ERROR | Exudyn, s | steps | ratio |\n|---|---|---|---|---|---|---|")
    for windows in map(int, arguments.windows.split(",")):
        for limit in (1e-3, 1e-5):
            errors = [f"{m}E-{k}" for k in range(2, 8) for m in (1, 0.3)]
            own = first_within(limit, [(e, lambda e=e: ours(admire, windows, e)) for e in errors])
            counts = [int(500 * 1.5**k) for k in range(14)]
            other = first_within(limit, [(n, lambda n=n: theirs(windows, n)) for n in counts])
            if own and other:
                print(
                    f"| {2 * windows + 1} | {limit:.0e} | {own[0]:.3f} ({own[1]:.1e}) | {own[2]} "
                    f"| {other[0]:.3f} ({other[1]:.1e}) | {other[2]} | {other[0] / own[0]:.1f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
