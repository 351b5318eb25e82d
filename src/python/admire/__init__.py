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
from ._deck import AxleTests, Change, Deck, Sensitivity, Values, read
from ._errors import AddressError, AdmireError, Complaint, DeckError, Place, SolveError
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
    diagnose,
    identify,
    kc,
    plan,
)
from ._sweep import Sweep, merge, sweep

__all__ = [
    "AddressError",
    "AdmireError",
    "AxleTests",
    "Candidate",
    "Change",
    "Complaint",
    "Deck",
    "DeckError",
    "Diagnosis",
    "Finding",
    "Identification",
    "Parameter",
    "Place",
    "Plan",
    "Repeated",
    "Results",
    "Rival",
    "Run",
    "Sensitivity",
    "SolveError",
    "Study",
    "Sweep",
    "Values",
    "__version__",
    "diagnose",
    "identify",
    "kc",
    "merge",
    "plan",
    "read",
    "results",
    "sweep",
]
