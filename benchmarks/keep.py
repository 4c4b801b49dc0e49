"""Run a benchmark and keep what it prints, for pages that state its numbers: ``python benchmarks/keep.py NAME [ARGUMENTS]``.

``benchmarks/results/NAME.json`` then holds the lines, and on which machine, when and of which commit they were measured. A part of a page
between ``<!-- measured: NAME -->`` and ``<!-- end of measured -->`` may hold no number that is not among them, rounded as on the page:
`tests/test_measured.py`.
"""

import json
import os
import platform
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

HERE = Path(__file__).parent
RESULTS = HERE / "results"


def commit():
    """The commit that is measured, with a plus where files have been changed since."""
    try:
        said = [
            subprocess.run(["git", *words], cwd=HERE, capture_output=True, text=True, check=True).stdout.strip()
            for words in (["rev-parse", "--short=12", "HEAD"], ["status", "--porcelain", "../src", "."])
        ]
    except (OSError, subprocess.CalledProcessError):
        return ""
    return said[0] + ("+" if said[1] else "")


def machine():
    """Processor and number of cores."""
    info = Path("/proc/cpuinfo")
    names = (
        [line.partition(":")[2].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
        if info.exists()
        else []
    )
    return f"{names[0] if names else platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def shown(argument):
    """An argument as it is kept: of a path, which is that of one computer alone, its last part."""
    return Path(argument).name if Path(argument).is_absolute() else argument


def main():
    name, *arguments = sys.argv[1:]
    began = datetime.now(UTC)
    lines = []
    with subprocess.Popen(
        [sys.executable, "-u", HERE / f"{name}.py", *arguments], stdout=subprocess.PIPE, text=True
    ) as process:
        for line in process.stdout:
            print(line, end="", flush=True)
            lines.append(line.rstrip("\n"))
    if process.returncode:
        sys.exit(process.returncode)
    RESULTS.mkdir(exist_ok=True)
    found = {
        "command": " ".join(["python", f"benchmarks/{name}.py", *map(shown, arguments)]),
        "date": began.date().isoformat(),
        "commit": commit(),
        "machine": machine(),
        "load_average": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None,
        "printed": lines,
    }
    (RESULTS / f"{name}.json").write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
