"""Worker processes leave when the process that asked them for work is gone.

A process that is killed outright cannot tell its workers to stop: they would wait for more work for minutes, with their
memory and its terminal in their hands, while it is started again.
"""

import os
import time
from threading import Thread

#: Seconds between two looks.
_INTERVAL = 0.5


def leave_with(parent: int) -> None:
    """In a new child of the process `parent`: end when that process has."""
    Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_INTERVAL)
    os._exit(1)
