"""ADAMS datasets in Python: read, change, check and solve them, identify bushing stiffnesses, and find what a model gets wrong.

>>> import admire
>>> deck = admire.read("corpus/pseudo-mcpherson/model.adm")
>>> deck["BUSHING/1.K.1"] = 12000.0
>>> run = deck.solve()
>>> run["BUSHING/1.FX"].shape
(2,)

Everything happens in this process, without files: no ADAMS, no ``mdi``, no folder for runs. The answers are those of the command line,
bit for bit. Long work releases the lock of the interpreter and ends within a second of Ctrl-C.
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
