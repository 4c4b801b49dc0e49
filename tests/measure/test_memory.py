"""A log that is longer takes no more memory."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

MAP = 'raster = "1 ms"\n[[channel]]\nsource = "time"\nrole = "time"\n' + "".join(
    f'[[channel]]\nsource = "p{n}"\nrole = "input"\nunit = "bar"\nraster = "1 ms"\n' for n in range(8)
)
IMPORT = """
from pathlib import Path
from polydraulic.measure import import_log, load_channels, write_quality
imported = import_log("log.parquet", load_channels("map.toml"), "table.parquet")
write_quality(imported, "quality.html")
status = Path("/proc/self/status").read_text()  # of this process alone: resource's number begins with its parent's
print(imported.n_row, float(status.partition("VmHWM:")[2].split()[0]) / 1024)
"""


def peak(folder, n):
    """Rows of the table and the largest memory in MiB of an import of n rows."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    rng = np.random.default_rng(0)
    columns = {"time": np.arange(n) * 1e-3, **{f"p{k}": rng.normal(100.0, 5.0, n) for k in range(8)}}
    pq.write_table(pa.table(columns), folder / "log.parquet", row_group_size=100_000)
    (folder / "map.toml").write_text(MAP)
    done = subprocess.run([sys.executable, "-c", IMPORT], cwd=folder, capture_output=True, text=True, check=True)
    rows, memory = done.stdout.split()
    assert int(rows) == n
    return float(memory)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the largest memory is read from /proc")
def test_memory_does_not_grow_with_the_log(tmp_path):
    short, long = peak(tmp_path, 600_000), peak(tmp_path, 3_000_000)
    assert long < 1024.0
    assert long - short < 60.0  # MiB; the log is 165 MiB longer
