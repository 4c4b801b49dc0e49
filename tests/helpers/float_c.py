"""Exported `float` C, compiled in several ways: the judged of proved allowances."""

import ctypes
import subprocess

import numpy as np

from polydraulic.export import bundle, to_c

# With and without fused multiply-adds; with and without numbers below 2^-126.
WAYS = {
    "O2": ["-std=c99", "-O2", "-ffp-contract=off"],
    "fused": ["-std=c99", "-O3", "-march=native", "-ffp-contract=fast"],
    "flushed": ["-std=c99", "-O2", "-DFLUSHED"],
}
_MANY = """
#include "{name}.c"
#ifdef FLUSHED
#include <xmmintrin.h>
#endif
void many(int count, const float *x, float *y, int *status)
{{
    int i;
#ifdef FLUSHED
    const unsigned int before = _mm_getcsr();
    _mm_setcsr(before | 0x8040u);
#endif
    for (i = 0; i < count; ++i) {{
        status[i] = {name}(x + {n} * i, y + {m} * i);
    }}
#ifdef FLUSHED
    _mm_setcsr(before);
#endif
}}
"""


def float_c(models, folder, way="O2"):
    """A function from float32 rows to statuses and outputs."""
    whole = bundle(models, name="net")
    n, m = len(whole.inputs), len(models)
    for file, text in zip(("net.h", "net.c"), to_c(whole, real="float"), strict=True):
        (folder / file).write_text(text)
    (folder / "many.c").write_text(_MANY.format(name="net", n=n, m=m))
    library = folder / f"{way}.so"
    command = ["gcc", *WAYS[way], "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC"]
    subprocess.run([*command, str(folder / "many.c"), "-o", str(library), "-lm"], check=True)
    function = ctypes.CDLL(str(library)).many

    def many(X):
        X = np.ascontiguousarray(X, dtype=np.float32)
        y, status = np.empty((len(X), m), dtype=np.float32), np.empty(len(X), dtype=np.int32)
        function(len(X), *(array.ctypes.data_as(ctypes.c_void_p) for array in (X, y, status)))
        return status, y.astype(np.float64)

    return many


def ways():
    """Those that this machine can do."""
    found = []
    for way, flags in WAYS.items():
        source = (
            "#include <xmmintrin.h>\nint main(void) { return 0; }"
            if way == "flushed"
            else "int main(void) { return 0; }"
        )
        tried = subprocess.run(
            ["gcc", *flags, "-xc", "-", "-o", "/dev/null"], input=source, text=True, capture_output=True
        )
        found += [way] if tried.returncode == 0 else []
    return found
