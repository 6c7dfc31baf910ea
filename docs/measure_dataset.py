"""Make a dataset and write docs/results/dataset.json: what it holds, and the time and memory that making it took.

python docs/measure_dataset.py OUT [options of footsel dataset]
"""

import contextlib
import sys
import time
from pathlib import Path

import psutil

from footsel.benchmark.machine import cpu_name
from footsel.dataset import open_dataset
from footsel.files import write_json

RESULT = Path(__file__).resolve().parent / "results" / "dataset.json"
#: Between two looks at the memory, in [s].
INTERVAL = 0.25


def main() -> int:
    """Run the command, watch it, and read the manifest."""
    if len(sys.argv) < 2 or Path(sys.argv[1]).exists():
        print("give a new folder: one that was begun before would not tell the time", file=sys.stderr)
        return 2
    out, options = Path(sys.argv[1]), sys.argv[2:]
    began, peak = time.monotonic(), 0
    command = psutil.Popen([sys.executable, "-m", "footsel.cli.main", "dataset", str(out), *options])
    while command.poll() is None:
        peak = max(peak, memory(command))
        time.sleep(INTERVAL)
    seconds = time.monotonic() - began
    if command.returncode:
        return int(command.returncode)
    manifest = open_dataset(out).manifest
    held = ("samples", "unknown_share", "reason_shares", "families")
    write_json(
        RESULT,
        {
            "command": " ".join(["footsel dataset OUT", *options]),
            "cpu": cpu_name(),
            "cores": psutil.cpu_count(),
            "seconds": round(seconds, 1),
            "peak_memory_mb": round(peak / 1e6),
            "disk_mb": round(sum(path.stat().st_size for path in out.rglob("*") if path.is_file()) / 1e6),
            "config": manifest["config"],
            "versions": manifest["versions"],
            **{key: manifest[key] for key in held},
        },
    )
    return 0


def memory(process: psutil.Process) -> int:
    """Of a process and all that it started, what they share counted once, in bytes."""
    total = 0
    with contextlib.suppress(psutil.NoSuchProcess):
        for each in (process, *process.children(recursive=True)):
            with contextlib.suppress(psutil.Error):
                used = each.memory_full_info()
                total += getattr(used, "pss", used.rss)
    return total


if __name__ == "__main__":
    sys.exit(main())
