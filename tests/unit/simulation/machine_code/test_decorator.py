"""Where the machine code of a function comes from, in processes of their own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pirate_sm.simulation.machine_code.built_library import find_library

FOUND = find_library()
built = pytest.mark.skipif(FOUND.library is None, reason=f"no library here: {FOUND.why_not}")

ROOT = Path(__file__).resolve().parents[4]

SHORT = """
import sys
sys.modules["numba"] = None  # as if it were not installed
import pirate_sm
try:
    print(pirate_sm.run("climb", "sim").outcome)
except pirate_sm.UsageError as error:
    print(error)
"""

# Every bit of a robot's state in each of the 1,800 cycles of a bend, with an obstacle, with noise
# that is drawn anew; then of the reduced physics, with both of its contacts.
ALL_BITS = """
import hashlib
import numpy as np
import pirate_sm
from pirate_sm.lab.experiments.reduced_kernel import simulate
from pirate_sm.simulation.kinematic.world import World

hashed, advance = hashlib.sha256(), World.advance

def advance_and_note(self):
    advance(self)
    hashed.update(self.state.array.tobytes() + self.quantities.tobytes())

World.advance = advance_and_note
run = pirate_sm.run("mitre_bend", "sim", seed=11, friction_jitter=0.1)
frames = [event for step in run.steps() for event in [step.event] if hasattr(event, "values")]
hashed.update(repr(frames).encode())

random, ticks, wheels = np.random.default_rng(3), 200, 6
for sticks in (False, True):
    out = np.zeros((ticks, 2 + 3 * wheels))
    simulate(
        np.tile([0.7, 0.5, 0.001, 1e5, 50.0], (wheels, 1)),
        np.array([2.5, 0.02, 3.0, 0.001]),
        np.column_stack([random.uniform(low, 1.0, ticks) for low in (0.0, -1.0, 0.0)]),
        random.uniform(5.0, 20.0, (ticks, wheels)),
        random.normal(0.0, 0.001, (ticks, wheels)),
        sticks, 20, out, np.zeros((5, wheels)),
    )
    hashed.update(out.tobytes())
print(len(frames), run.outcome, hasattr(simulate, "py_func"), hashed.hexdigest())
"""


def told(code: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.stdout.strip() or done.stderr


@pytest.mark.thorough
@built
def test_the_simulator_needs_no_numba() -> None:
    assert told(SHORT) == "succeeded"


@pytest.mark.thorough
@built
def test_without_machine_code_and_numba_it_is_told_what_to_install() -> None:
    assert told(SHORT, PIRATE_SM_JIT="1") == (
        "the simulator cannot run here: PIRATE_SM_JIT is set; pip install 'pirate-sm[jit]' lets it "
        "compile itself when it is first used (or use the backend trace)"
    )


@pytest.mark.slow
@pytest.mark.timeout(900)  # on a busy machine numba takes minutes
@built
def test_built_and_compiled_when_called_agree_in_every_bit() -> None:
    pytest.importorskip("numba")
    *ahead, is_jit, bits = told(ALL_BITS).split()
    *there, was_jit, others = told(ALL_BITS, PIRATE_SM_JIT="1").split()

    assert (is_jit, was_jit) == ("False", "True")
    assert int(ahead[0]) > 1000
    assert (ahead, bits) == (there, others)
