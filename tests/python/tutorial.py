"""The way of the tutorial in Python, as a notebook would go it. Each block is a cell; the tests run the file."""

# %% A deck: what it says, and what is wrong with it.
import numpy as np

import admire

deck = admire.read("corpus/pseudo-mcpherson/model.adm")
print(deck.title)
print([complaint.message for complaint in deck.check() if complaint.severity == "error"])
print(deck["BUSHING/*.K"])

# %% An equilibrium under a load, and a curve of wheel loads from one command file.
run = deck.solve({"SFORCE/3": 4000.0})
print(run.columns[:8])
loads = np.linspace(0.0, 4000.0, 9)
commands = "".join(f"SFORCE/3, FUNCTION={load}\nSIMULATE/STATICS\n" for load in loads)
curve = deck.solve(commands=commands)
forces = curve["BUSHING/3.FZ"][1:]
assert forces.shape == loads.shape
assert np.all(np.diff(forces) > 0.0) or np.all(np.diff(forces) < 0.0), "more load, more force in the top mount"

# %% What a stiffness does: a variant for each value, and the exact derivative beside it.
stiffnesses = [8000.0, 10000.0, 12000.0]
found = [deck.solve({"SFORCE/1": 1000.0, "BUSHING/1.K.1": k})["BUSHING/1.FX"][-1] for k in stiffnesses]
loaded = deck.copy()
loaded["SFORCE/1"] = 1000.0
table = loaded.sensitivity(of="BUSHING/1", by="BUSHING/1.K.1")
slope = (found[2] - found[0]) / (stiffnesses[2] - stiffnesses[0])
assert abs(slope - table.values[0, 0]) < 0.1 * abs(slope)

# %% Identify: stiffnesses with their uncertainty.
answer = admire.identify("corpus/pseudo-mcpherson")
print(answer.summary)
reference = admire.read("corpus/pseudo-mcpherson/reference.adm")
for parameter in answer.parameters:
    if parameter.status == "identified":
        low, high = parameter.interval95
        print(parameter.address, parameter.value, parameter.std_error, reference[parameter.address])
        assert low is not None and high is not None and low < parameter.value < high
true = reference["BUSHING/1.K.1"]
first = answer["BUSHING/1.K.1"]
assert abs(first.value - true) < 4.0 * first.std_error
assert abs(true - first.value) < abs(true - first.initial)

# %% Diagnose: what the model still gets wrong. The shipped experiment has dry friction and a flexible tie rod that its deck does not know.
diagnosis = admire.diagnose("corpus/kc-experiment")
print(diagnosis.sentences)
assert diagnosis.verdict == "discrepancy"
causes = {finding.cause for finding in diagnosis.findings if finding.probability > 0.5}
assert any("friction" in cause for cause in causes), causes
assert "<html" in diagnosis.html and "srcdoc" in diagnosis._repr_html_()

# %% Go on with the better model.
extended = diagnosis.deck
assert extended.diff(admire.read("corpus/kc-experiment/model.adm"))
print(extended.solve().exit_code)
