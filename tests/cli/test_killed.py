"""Commands that are killed, starved or doubled: nothing half-written stands where a file belongs, and the next run is right."""

import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from helpers.fuzz import MAP, OWN_TIME
from helpers.machine_log import machine_log
from helpers.small_network import NODES
from polydraulic.networks import Model, Network, Variable, save_models
from polydraulic.tables import write_table

pytestmark = pytest.mark.slow

COMMANDS = {
    "simulate": "simulate single_05 --flow exact --out out/run.parquet",
    "import": "import log.csv --channels map.toml --out out/table.parquet",
    "fit-machine": "fit-machine table.parquet --out out/machine.json --regions 1 --rows 300 --blocks 5",
    "export": "export model.json --to c --out out",
    "export as an FMU": "export model.json --to fmi2 --out out/model.fmu",
    "report": "report --figure 3-4 --out out",
}
# ends the program as `kill -9` does, when it is about to put its N-th file in its place
KILLED = """
import os, pathlib, signal, sys
from polydraulic import cli

left = [int(sys.argv.pop(1))]
move = pathlib.Path.replace

def replace(path, target):
    left[0] -= "out" in pathlib.Path(target).parts
    if left[0] == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return move(path, target)

pathlib.Path.replace = replace
cli.main()
"""


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inputs")
    t = np.arange(3000) * 0.01
    rows = np.column_stack([t, 10.0 * np.sin(t), 100.0 + np.round(20.0 * np.cos(3.0 * t), 1), 50.0 * np.sin(t) ** 2])
    head = "time,x,p,q\n"
    (folder / "log.csv").write_text(head + "".join(",".join(f"{v:.6g}" for v in row) + "\n" for row in rows))
    (folder / "map.toml").write_text(MAP.format(time=OWN_TIME))
    write_table(machine_log(30.0), folder / "table.parquet")
    network = Network(tuple(NODES), (0.0, 1.0), (1.0, 2.0), (-3.0, -3.0), (3.0, 4.0), 2.0, 1.0)
    save_models(
        [Model((Variable("a", "m"), Variable("b", "Pa")), Variable("y", "Pa"), (network,))], folder / "model.json"
    )
    return folder


def start(folder, command, *before, limit=None, **more):
    """Begin a command in a folder."""
    program = [sys.executable, *(before or ("-m", "polydraulic")), *command.split()]
    return subprocess.Popen(
        program, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=limit, **more
    )


def written(folder):
    """Contents of what a command wrote; what it keeps to go on is left aside."""
    out = folder / "out"
    paths = [path for path in out.rglob("*") if path.is_file() and "cache" not in path.relative_to(out).parts]
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in paths}


def whole(folder):
    return {name: content for name, content in written(folder).items() if ".unfinished-" not in name}


@pytest.fixture(scope="module")
def undisturbed(inputs, tmp_path_factory):
    """What a command writes if nothing happens to it."""
    made = {}

    def of(name):
        if name not in made:
            folder = tmp_path_factory.mktemp("undisturbed")
            shutil.copytree(inputs, folder, dirs_exist_ok=True)
            run = start(folder, COMMANDS[name])
            _, errors = run.communicate()
            assert run.returncode == 0, errors
            made[name] = written(folder)
            assert made[name]
        return made[name]

    return of


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_that_is_killed_leaves_whole_files_and_the_next_is_right(name, inputs, undisturbed, tmp_path):
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    expected = undisturbed(name)
    for number in range(1, 10):
        run = start(tmp_path, f"{number} {COMMANDS[name]}", "-c", KILLED)
        run.communicate()
        if run.returncode == 0:
            break
        assert run.returncode == -signal.SIGKILL
        assert number > 1 or any(".unfinished-" in found for found in written(tmp_path))  # it was writing
        assert whole(tmp_path).items() <= expected.items()
        if number > 1:
            shutil.rmtree(tmp_path / "out")
    assert number > 1
    run = start(tmp_path, COMMANDS[name])
    _, errors = run.communicate()
    assert (run.returncode, errors) == (0, "")
    assert written(tmp_path) == expected


@pytest.mark.parametrize("name", ["simulate", "import", "report"])
def test_a_command_that_is_killed_at_any_time_leaves_whole_files(name, inputs, undisturbed, tmp_path):
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    expected = undisturbed(name)
    began = time.monotonic()
    start(tmp_path, COMMANDS[name]).communicate()
    lasts = time.monotonic() - began
    for share in (0.2, 0.5, 0.8, 0.95):
        run = start(tmp_path, COMMANDS[name])
        time.sleep(share * lasts)
        run.kill()
        run.communicate()
        assert whole(tmp_path) == expected  # of the run before
    run = start(tmp_path, COMMANDS[name])
    assert run.communicate()[1] == ""
    assert written(tmp_path) == expected


@pytest.mark.parametrize("name", ["import", "export", "report"])
def test_two_at_once_do_not_disturb_each_other(name, inputs, undisturbed, tmp_path):
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    runs = [start(tmp_path, COMMANDS[name]) for _ in range(2)]
    assert [run.communicate()[1] for run in runs] == ["", ""]
    assert [run.returncode for run in runs] == [0, 0]
    assert written(tmp_path) == undisturbed(name)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_full_disk_is_one_error_and_no_file(name, inputs, tmp_path):
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    run = start(tmp_path, COMMANDS[name], limit=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (300, 300)))
    _, errors = run.communicate()
    assert run.returncode == 2
    assert errors.splitlines()[-1].startswith("error: cannot write ")
    assert "File too large" in errors
    assert "Traceback" not in errors
    assert all(len(content) <= 300 for content in written(tmp_path).values())


ON_A_SMALL_DISK = """mount -t tmpfs -o size="$1" none out && shift || exit 99
"$@"
code=$?
cp -r out kept
exit $code
"""
PAGE = 4096  # bytes that a file of a tmpfs is made of


def on_a_small_disk(folder, command, size):
    """Run a command whose folder `out` is a file system of so many bytes; its exit status, errors, and the files that it left."""
    (folder / "out").mkdir()
    before = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", ON_A_SMALL_DISK, "sh", str(size)]
    program = [*before, sys.executable, "-m", "polydraulic", *command.split()]
    run = subprocess.run(program, cwd=folder, capture_output=True, text=True)
    if run.returncode == 99 or "unshare failed" in run.stderr:
        pytest.skip("no file system may be mounted here")
    (folder / "out").rmdir()
    (folder / "kept").rename(folder / "out")
    return run.returncode, run.stderr, written(folder)


@pytest.mark.parametrize("name", ["simulate", "import", "export", "report"])
def test_a_disk_that_fills_up_is_one_error_and_no_file_in_part(name, inputs, undisturbed, tmp_path):
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    expected = undisturbed(name)
    pages = sum(-(-len(content) // PAGE) for content in expected.values())
    code, errors, left = on_a_small_disk(tmp_path, COMMANDS[name], max(1, pages // 2) * PAGE)
    assert code == 2
    assert errors.splitlines()[-1].startswith("error: cannot write ")
    assert "No space left on device" in errors
    assert "Traceback" not in errors
    assert left.items() < expected.items()


@pytest.mark.parametrize(("fits", "fails"), [((), "machine.json"), (("machine.json",), "machine.card.json")])
def test_a_disk_that_fills_up_while_a_machine_is_written(fits, fails, inputs, undisturbed, tmp_path):
    """Before the models are written, and between them and their card."""
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    expected = undisturbed("fit-machine")
    pages = sum(-(-len(expected[name]) // PAGE) for name in fits)
    command = COMMANDS["fit-machine"] + " --card out/machine.html --boxes 1"
    code, errors, left = on_a_small_disk(tmp_path, command, (pages + 1) * PAGE)
    assert code == 2
    assert errors.splitlines()[-1].startswith(f"error: cannot write out/{fails}: No space left on device")
    assert "Traceback" not in errors
    assert left == {name: expected[name] for name in fits}


@pytest.mark.parametrize("name", ["simulate", "import", "export", "report"])
def test_few_open_files_are_enough(name, inputs, undisturbed, tmp_path):
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    run = start(tmp_path, COMMANDS[name], limit=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (32, 32)))
    _, errors = run.communicate()
    assert (run.returncode, errors) == (0, "")
    assert written(tmp_path) == undisturbed(name)


# a command would compile much more
PREDICT = """
import numpy as np
from pathlib import Path
from polydraulic.networks import load_models
(model,) = load_models("model.json")
Path("out").mkdir(exist_ok=True)
Path("out/y.txt").write_text(model.predict(np.random.default_rng(0).uniform(size=(50, 2))).tobytes().hex())
"""


def test_two_at_once_share_a_new_cache_of_kernels(inputs, tmp_path):
    for folder in "abc":
        shutil.copytree(inputs, tmp_path / folder)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert start(tmp_path / "c", "", "-c", PREDICT).communicate()[1] == ""
    for _ in range(2):  # the second time from what the first left
        runs = [start(tmp_path / folder, "", "-c", PREDICT, env=environment) for folder in "ab"]
        assert [run.communicate()[1] for run in runs] == ["", ""]
        assert written(tmp_path / "a") == written(tmp_path / "b") == written(tmp_path / "c")
    kept = list((tmp_path / "cache").rglob("*.nbc"))
    assert kept
    for path in kept:
        path.write_bytes(path.read_bytes()[:-1000])
    run = start(tmp_path / "a", "", "-c", PREDICT, env=environment)
    assert run.communicate()[1] == ""
    assert written(tmp_path / "a") == written(tmp_path / "c")


# more than 6 billion steps of a machine: minutes on two processors, in pieces of seconds that cannot be stopped
BATCH = """
import numpy as np
from polydraulic import load_machine, simulate_batch
machines = [load_machine("cat215b")] * 6400
simulate_batch(machines, "exact", np.zeros((10, 3)))
print("busy", flush=True)
try:
    simulate_batch(machines, "exact", np.zeros((1_000_000, 3)))
except KeyboardInterrupt:
    print("interrupted", flush=True)
    raise
"""


def test_an_interrupt_ends_a_batch_at_once(tmp_path):
    run = start(tmp_path, "", "-c", BATCH)
    assert run.stdout.readline() == "busy\n"
    time.sleep(2.0)
    run.send_signal(signal.SIGINT)
    began = time.monotonic()
    assert run.stdout.readline() == "interrupted\n"
    assert time.monotonic() - began < 5.0
    errors = run.communicate()[1]
    assert time.monotonic() - began < 60.0  # Python clears up, which takes longer where others compute
    assert errors.rstrip().endswith("KeyboardInterrupt")
