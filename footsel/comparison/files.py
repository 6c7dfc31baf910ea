"""The folder of a comparison: both files or none."""

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

FIGURES_FILE = "compare.json"
WALKS_FILE = "walks.json"
REPORT_FILE = "report.html"


def write_comparison(out: Path, figures: Mapping[str, Any], report: str, figures_file: str = FIGURES_FILE) -> Path:
    """Write the figures and `report.html` into folder `out`, made if it is not there. Returns the report's path.

    Everything is written beside `out` first and then put in its place, so that no half report is ever seen.
    """
    out = out.resolve()
    out.parent.mkdir(parents=True, exist_ok=True)
    temporary = out.with_name(f".{out.name}.{os.getpid()}.tmp")
    temporary.mkdir()
    try:
        (temporary / figures_file).write_text(json.dumps(figures, indent=2, allow_nan=False) + "\n", encoding="utf-8")
        (temporary / REPORT_FILE).write_text(report, encoding="utf-8")
        if out.exists():
            for name in (figures_file, REPORT_FILE):
                (temporary / name).replace(out / name)
        else:
            temporary.rename(out)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return out / REPORT_FILE
