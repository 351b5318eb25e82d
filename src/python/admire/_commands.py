"""The commands ``admire`` and ``mdi``, which the package installs."""

import shutil
import signal
import sys
from collections.abc import Callable
from typing import NoReturn

from ._admire import run_admire, run_mdi


def admire() -> NoReturn:
    """Run the command ``admire`` with the arguments of this process."""
    _run(run_admire)


def mdi() -> NoReturn:
    """Run the drop-in solver ``mdi`` with the arguments of this process."""
    _run(run_mdi)


def _run(command: Callable[[list[str]], int]) -> NoReturn:
    # Python would hold Ctrl-C back until the command has ended.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # On Windows the launcher takes the `.exe` off.
    program = shutil.which(sys.argv[0]) or sys.argv[0]
    sys.exit(command([program, *sys.argv[1:]]))
