"""ADAMS datasets in Python: read, change, check and solve them, identify bushing stiffnesses, and diagnose the faults of a model.

>>> import admire
>>> deck = admire.read("corpus/pseudo-mcpherson/model.adm")
>>> deck["BUSHING/1.K.1"] = 12000.0
>>> run = deck.solve()
>>> run["BUSHING/1.FX"].shape
(2,)

All computations run in this process, without ADAMS, without ``mdi`` and without files. The results are identical to those of the command
line. Long computations release the interpreter lock, and Ctrl-C stops them within a second.
"""

from ._admire import __version__
from ._axle import AxleTests
from ._deck import Change, Deck, Sensitivity, Values, read
from ._errors import AddressError, AdmireError, Complaint, DeckError, Place, SolveError
from ._objects import Objects
from ._run import Results, Run, results
from ._study import (
    Candidate,
    Diagnosis,
    Finding,
    Identification,
    Parameter,
    Plan,
    Repeated,
    Rival,
    Study,
    TunedGoal,
    TunedNumber,
    Tuning,
    diagnose,
    identify,
    kc,
    plan,
    tune,
)
from ._sweep import Sweep, merge, sweep
from ._tools import Comparison, RigRun, View, compare, new, rig, view

__all__ = [
    "AddressError",
    "AdmireError",
    "AxleTests",
    "Candidate",
    "Change",
    "Comparison",
    "Complaint",
    "Deck",
    "DeckError",
    "Diagnosis",
    "Finding",
    "Identification",
    "Objects",
    "Parameter",
    "Place",
    "Plan",
    "Repeated",
    "Results",
    "RigRun",
    "Rival",
    "Run",
    "Sensitivity",
    "SolveError",
    "Study",
    "Sweep",
    "TunedGoal",
    "TunedNumber",
    "Tuning",
    "Values",
    "View",
    "__version__",
    "compare",
    "diagnose",
    "identify",
    "kc",
    "merge",
    "new",
    "plan",
    "read",
    "results",
    "rig",
    "sweep",
    "tune",
    "view",
]
