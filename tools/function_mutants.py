"""Changes what stands in functions, one change at a time (mutmut), and says which changes no test notices (`make mutants`).

One module after the other, by its own tests; of a module without tests of its own by those of its folder. What survived is shown as a
difference. The changed code goes into mutants/.

    python tools/function_mutants.py [MODULE ...]      # such as measure.checks.clock; those of [tool.mutmut] if none is given
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from typing import Any

from constant_mutants import OUTCOMES, ROOT, modules, source_of, tests_of

NOTICED = ("killed", "timeout", "suspicious", "segfault", "caught by type check")


def judge(module: str) -> None:
    """Print what is noticed of the changes of a module; once a process, since its tests are loaded with the changed code."""
    shutil.rmtree("mutants", ignore_errors=True)  # files of earlier modules would count as changed already
    mutmut = import_module("mutmut.__main__")
    configuration: Any = import_module("mutmut.configuration")
    configuration._config = replace(
        configuration.config(),
        only_mutate=[str(source_of(module).relative_to(ROOT))],
        pytest_add_cli_args_test_selection=tests_of(module),
    )
    _quietly(lambda: mutmut._run([f"polydraulic.{module}.*"], 1))
    counts, left = Counter[str](), []
    for path in mutmut.walk_mutatable_files():
        data = mutmut.SourceFileMutationData(path=path)
        data.load()
        for name, code in data.exit_code_by_key.items():
            status = mutmut.status_by_exit_code[code]
            outcome = "killed" if status in NOTICED else "not covered" if status == "no tests" else "survived"
            counts[outcome] += 1
            left += [mutmut.get_diff_for_mutant(name, path=path)] * (outcome == "survived")
    words = ", ".join(f"{counts[outcome]} {outcome}" for outcome in OUTCOMES)
    print("\n".join([*left, f"{module}: {counts.total()} changes of functions: {words}"]), flush=True)


def _quietly(work: Callable[[], object]) -> None:
    """Do something of which only an early end is worth its words; what forks of this process say is none of them either."""
    with tempfile.TemporaryFile() as said:
        kept = os.dup(1)
        os.dup2(said.fileno(), 1)
        try:
            work()
            ended = False
        except SystemExit:
            ended = True
        finally:
            for stream in (sys.stdout, sys.__stdout__):
                if stream is not None:
                    stream.flush()
            os.dup2(kept, 1)
            os.close(kept)
        if ended:
            said.seek(0)
            sys.exit(said.read().decode(errors="replace").replace("\r", "\n"))


def main(chosen: list[str]) -> None:
    """Print what is noticed, module by module."""
    os.chdir(ROOT)
    found = modules(chosen)
    if len(found) == 1:
        judge(found[0])
        return
    for module in found:
        subprocess.run([sys.executable, __file__, module], check=True)


if __name__ == "__main__":
    main(sys.argv[1:])
