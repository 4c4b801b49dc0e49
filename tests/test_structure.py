"""The house itself: sizes of files and folders, names that mean one thing, tests where their modules are."""

import ast
import re
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SRC, TESTS = ROOT / "src" / "polydraulic", ROOT / "tests"
MODULES = sorted(path.relative_to(SRC).as_posix() for path in SRC.rglob("*.py"))

# Modules, or whole folders, whose tests stand elsewhere: where, and why.
TESTED_ELSEWHERE = {
    "control/runs.py": ("control/test_coordinated.py", "closed runs of the controller there"),
    "control/text.py": ("control/test_coordinated.py", "its kernels are what the controller does"),
    "machine/stability/body.py": ("machine/stability/test_whole_body.py", "its kernels are called there"),
    "machine/stability/vectors.py": ("machine/stability/test_margins.py", "what margins are made of"),
    "machine/stability/watched.py": ("simulation/layout/stability/test_columns.py", "the columns are its rows"),
    "cli/": ("cli/test_commands.py", "commands are tested as a user calls them, whatever module they are in"),
    "simulation/changed_flow.py": ("simulation/test_faults.py", "machines break there with several flow models"),
    "cockpit/coordination.py": ("cockpit/test_cab.py", "the machine that is driven there is coordinated, too"),
    "cockpit/description.py": ("cockpit/test_cab.py", "the machine that is driven there is described"),
    "cockpit/study/table.py": ("cockpit/study/test_course.py", "the course there ends in its table"),
    "cockpit/open_cockpit.py": ("cli/test_cockpit.py", "the command opens one"),
    "cockpit/recorded/drives.py": (
        "cockpit/recorded/test_player.py",
        "files of drives are read there, and written in test_keeper.py",
    ),
    "cockpit/recorded/tape.py": ("cockpit/recorded/test_player.py", "tapes are played there"),
    "cockpit/shadow.py": ("cockpit/test_cab.py", "it follows the machine that is driven there"),
    "cockpit/view.py": ("cockpit/test_cab.py", "columns of the frames there"),
    "cockpit/wanted.py": ("cockpit/test_cab.py", "records"),
    "cockpit/web/": ("cockpit/web/test_server.py", "what is served, to whom, is seen by a client"),
    "columns/": ("measure/formats/test_csv_log.py", "files of all kinds are opened, and read as a whole"),
    "errors.py": ("parameters/test_load.py", "two names of exceptions"),
    "export/build.py": ("export/fmu/test_networks.py", "a compiler is found and called to build FMUs"),
    "export/c/network.py": ("export/c/test_source.py", "the functions are compiled with the source that holds them"),
    "export/c/answers.py": ("export/c/test_source.py", "both forms are compiled and compared there"),
    "export/c/tables.py": ("export/c/test_source.py", "tables are held to the bits of straight-line code there"),
    "export/onnx/graph.py": ("export/onnx/test_model.py", "graphs run in ONNX Runtime there"),
    "export/onnx/tables.py": ("export/onnx/test_model.py", "both forms run in ONNX Runtime there"),
    "export/fresh.py": ("export/test_verify.py", "every target runs in a process of its own there"),
    "export/fresh_script.py": ("export/test_verify.py", "what those processes run"),
    "export/fmu/due.py": ("export/fmu/test_machine.py", "steps of the machine there, and rows in ../watch/test_fmu.py"),
    "export/fmu/xml.py": ("export/fmu/test_networks.py", "descriptions are validated and read by importers"),
    "export/fmu/machine_parameters.py": (
        "export/fmu/test_machine.py",
        "parameters of the machine that is exported there",
    ),
    "export/machine_parts.py": ("export/test_machine.py", "a record"),
    "networks/dynamic/joint_network.py": (
        "networks/dynamic/test_joint_regressor.py",
        "the network runs as the polynomial that was learnt, on new logs",
    ),
    "networks/dynamic/free_runner.py": (
        "networks/dynamic/test_dynamic_regressor.py",
        "runs of both estimators that stand on it",
    ),
    "networks/dynamic/signal_names.py": ("networks/dynamic/test_joint_regressor.py", "models under other names"),
    "networks/growth/checked_settings.py": (
        "networks/growth/test_regressor.py",
        "estimators refuse settings when they are fitted",
    ),
    "parameters/entries.py": ("parameters/test_load.py", "entries are read as parts of files"),
    "parameters/layout/conditions.py": ("parameters/layout/test_load.py", "conditions refuse files"),
    "parameters/layout/reader.py": ("parameters/layout/test_load.py", "parts are read as parts of files"),
    "parameters/layout/parts.py": ("parameters/layout/test_load.py", "records that files become"),
    "simulation/batch/family.py": ("simulation/batch/test_layout_batch.py", "batches of every layout"),
    "simulation/lane_blocks.py": ("simulation/batch/test_batch.py", "what batches keep"),
    "simulation/layout/events.py": ("simulation/test_events.py", "events of runs"),
    "simulation/layout/methods/lsoda.py": ("simulation/layout/methods/test_rosenbrock.py", "the judge of the others"),
    "simulation/layout/page_lists.py": ("simulation/layout/test_text.py", "lists become the text"),
    "simulation/layout/prepare.py": ("simulation/layout/test_runs.py", "numbers of the machines that run"),
    "simulation/layout/tree.py": ("parameters/layout/test_payload.py", "links as the equations of motion want them"),
    "simulation/stepping/batch_engine.py": (
        "simulation/stepping/test_batch_simulator.py",
        "what moves the machines there",
    ),
    "simulation/stepping/engine.py": ("simulation/stepping/test_simulator.py", "what moves the machine there"),
    "simulation/stepping/levers.py": ("simulation/stepping/test_simulator.py", "levers are moved and refused there"),
    "simulation/stepping/marks.py": ("simulation/stepping/test_simulator.py", "places and records"),
    "simulation/stepping/noted.py": ("simulation/stepping/test_simulator.py", "events are those of runs there"),
    "simulation/stepping/per_machine.py": ("simulation/stepping/test_batch_simulator.py", "arguments of batches"),
    "simulation/stepping/saved.py": ("simulation/stepping/test_simulator.py", "what is saved comes back there"),
    "simulation/stepping/setup.py": ("simulation/stepping/test_simulator.py", "what cannot be built is named there"),
    "simulation/stepping/stepped.py": ("simulation/stepping/test_simulator.py", "what one and many have in common"),
    "watch/block.py": (
        "watch/test_noise.py",
        "residuals of blocks there; their scores in test_directions.py, states in test_flat.py",
    ),
    "watch/learning.py": ("watch/test_watch.py", "what is to be expected of the machines that are watched there"),
    "watch/plan.py": ("watch/test_residuals.py", "what cases share is one step there"),
    "watch/watched.py": ("watch/test_watch.py", "machines that are watched, or refused"),
    "watch/kernels/numbers.py": ("watch/kernels/test_text.py", "what kernels are given there"),
    "watch/kernels/evidence.py": ("watch/test_sequential.py", "sums of evidence are gathered there"),
    "watch/kernels/scores.py": (
        "watch/kernels/test_text.py",
        "scores of a block there, whitening in ../test_expected.py",
    ),
    "watch/kernels/signals.py": ("watch/kernels/test_text.py", "steps of a block"),
    "watch/kernels/stays.py": ("watch/kernels/test_text.py", "sensors of a block there, and in ../test_flat.py"),
    "watch/kernels/windows.py": ("watch/kernels/test_text.py", "steps of a block"),
    "export/watch/networks.py": ("export/watch/test_source.py", "what networks say there is that of the package"),
    "export/watch/texts.py": ("export/watch/test_source.py", "lists in the text that is compiled there"),
    "export/translate/signatures.py": ("export/translate/test_program.py", "a record"),
    "simulation/layout/module.py": ("simulation/layout/test_text.py", "the module of a text"),
    "flow/interface.py": ("flow/test_dispatch.py", "records that every flow model gives"),
    "flow/training/circuit_models.py": ("flow/training/test_mode_models.py", "both learn in one run"),
    "gym/arguments.py": ("gym/test_machine_env.py", "environments are built and refused there"),
    "gym/episodes.py": ("gym/test_machine_vector_env.py", "episodes of environments"),
    "gym/motion.py": ("gym/test_machine_env.py", "columns that observations are made of"),
    "gym/picture.py": ("gym/test_machine_env.py", "pictures of environments"),
    "gym/registered.py": ("gym/test_machine_env.py", "names by which environments are made"),
    "gym/tasks/task.py": ("gym/tasks/test_reach.py", "what all tasks share"),
    "identification/equations/finished.py": (
        "identification/equations/test_identify.py",
        "circuits that were fitted there are kept",
    ),
    "identification/equations/free_runs.py": ("identification/equations/test_card.py", "runs that the card shows"),
    "identification/equations/fit/knots.py": (
        "identification/equations/fit/test_circuit_fit.py",
        "knots that the curves there lack are found",
    ),
    "identification/equations/mechanics/resting.py": (
        "identification/equations/ways/test_by_rest.py",
        "what joints carry at rest, of both frictions",
    ),
    "identification/equations/sensors.py": (
        "identification/equations/test_observations.py",
        "signals are read as parts of logs",
    ),
    "identification/equations/words.py": ("identification/equations/test_identify.py", "what a fit says"),
    "identification/machine/machine_card.py": (
        "identification/machine/test_machine_fit.py",
        "the card of the machine learnt there",
    ),
    "identification/run_plot.py": (
        "identification/test_runs.py",
        "pictures of the runs made there, and in test_log_replay.py",
    ),
    "machine/circuits/series/march_text.py": (
        "machine/circuits/series/test_text.py",
        "the march is held to the judge of the whole circuit",
    ),
    "machine/circuits/series/slopes.py": (
        "machine/circuits/series/test_slopes_text.py",
        "parts of the slopes held to differences there",
    ),
    "machine/reach/lines.py": ("gym/test_workspace.py", "lines that lead from starts"),
    "machine/reach/travels.py": ("gym/test_workspace.py", "travels of the machines there"),
    "machine/tree/constants_text.py": ("machine/tree/test_motion_text.py", "part of the text that is held to MuJoCo"),
    "machine/tree/equations.py": (
        "machine/tree/test_motion_text.py",
        "recorded mechanics are held to MuJoCo as a whole",
    ),
    "machine/tree/frames.py": ("machine/tree/test_motion_text.py", "recorded mechanics are held to MuJoCo as a whole"),
    "machine/tree/links.py": ("machine/tree/test_link_checks.py", "a record"),
    "machine/tree/mass.py": ("machine/tree/test_motion_text.py", "recorded mechanics are held to MuJoCo as a whole"),
    "machine/tree/points.py": ("machine/tree/test_motion_text.py", "points and forces there are held to MuJoCo"),
    "machine/newton_euler.py": (
        "simulation/layout/test_forces.py",
        "forces of links are held to MuJoCo with those of actuators and pins",
    ),
    "measure/columns_made.py": ("measure/test_flows.py", "records"),
    "measure/quality_plots.py": ("measure/test_quality.py", "pictures in the report"),
    "measure/formats/can/frames.py": ("measure/formats/can/test_can_log.py", "every format gives the same signals"),
    "measure/formats/ros/bag.py": ("measure/formats/ros/test_bag_log.py", "every format gives the same numbers"),
    "measure/formats/ros/fields.py": ("measure/formats/ros/test_bag_log.py", "messages are seen as columns of a log"),
    "measure/formats/ros/message_units.py": ("measure/formats/ros/test_bag_log.py", "units are those of signals"),
    "measure/formats/ros/topic_rows.py": ("measure/formats/ros/test_bag_log.py", "rows are seen as blocks of a log"),
    "measure/formats/mat/arrays.py": ("measure/formats/mat/test_mat_log.py", "both versions give the same columns"),
    "measure/formats/mat/hdf.py": ("measure/formats/mat/test_mat_log.py", "both versions give the same columns"),
    "measure/formats/mat/v5.py": ("measure/formats/mat/test_mat_log.py", "both versions give the same columns"),
    "measure/formats/mdf/conversion.py": ("measure/formats/mdf/test_mdf_log.py", "conversions are seen in files"),
    "measure/formats/parquet_log.py": ("measure/formats/test_csv_log.py", "in one list with text files"),
    "parameters/recording.py": ("parameters/test_scenario.py", "recordings are scenarios"),
    "networks/model/history.py": ("networks/growth/test_synthesis.py", "a record of growth"),
    "parameters/quantity.py": ("parameters/test_values.py", "ranges are held by whoever sets a value"),
    "plotting/carrier.py": ("plotting/test_layout_shapes.py", "machines are seen to stand on it"),
    "progress.py": ("test_terminal.py", "a protocol; what is told is shown"),
    "simulation/batch/batch_inputs.py": ("simulation/batch/test_batch.py", "arguments of `simulate_batch`"),
    "simulation/solvers/adaptive.py": (
        "simulation/layout/methods/test_rosenbrock.py",
        "coefficients and bounds of its steps",
    ),
    "simulation/solvers/line_rates.py": (
        "simulation/layout/methods/test_rosenbrock.py",
        "part of the rates of a machine",
    ),
    "simulation/solvers/line_slopes.py": (
        "simulation/layout/methods/test_rosenbrock.py",
        "part of the Jacobian of a machine",
    ),
    "simulation/solvers/stop_conditions.py": (
        "simulation/layout/methods/test_rosenbrock.py",
        "stops hold what they push",
    ),
    "thesis/beyond.py": ("thesis/report/test_write.py", "its numbers are held to what must be met"),
    "thesis/boom_models.py": ("thesis/report/test_write.py", "its numbers are held to what must be met"),
    "thesis/boom_perceptrons.py": ("thesis/report/test_write.py", "its numbers are held to what must be met"),
    "thesis/printed_units.py": ("test_tables.py", "columns as the thesis prints them are those shown in its system"),
    "thesis/report/": ("thesis/report/test_write.py", "the report is made and read as a whole"),
    "thesis/single_link.py": ("thesis/report/test_write.py", "its numbers are held to what must be met"),
    "thesis/three_links.py": ("thesis/report/test_write.py", "its numbers are held to what must be met"),
    "simulation/layout/flow_points.py": ("flow/layout/test_database.py", "next to the circuits as tables"),
    "thesis/excavator.py": ("thesis/test_historical.py", "the machine of all studies"),
}

# Public functions that several modules have, and why that confuses nobody.
SHARED_NAMES = {
    "content": "each chapter's, asked for by the report",
    "integrate": "a solver's, chosen by the method of `simulate`",
    "record": "of runs as logs, and of a step in a row: the kernel's name leaves as C",
}


def test_files_and_folders_are_small():
    long = {name: n for name in MODULES if (n := len((SRC / name).read_text(encoding="utf-8").splitlines())) > 400}
    assert long == {}
    flat = defaultdict(list)
    for name in MODULES:
        if not name.endswith("__init__.py"):
            flat[Path(name).parent.as_posix()].append(name)
    assert {folder: len(names) for folder, names in flat.items() if len(names) > 16} == {}


@cache
def statements(name):
    return ast.parse((SRC / name).read_text(encoding="utf-8")).body


def defined(kind):
    """Modules by the public names of a kind that they define."""
    found = defaultdict(list)
    for name in MODULES:
        for node in statements(name):
            overload = any(ast.unparse(d) == "overload" for d in getattr(node, "decorator_list", ()))
            if isinstance(node, kind) and not node.name.startswith("_") and not overload:
                found[node.name].append(name)
    return found


def test_a_public_class_name_means_one_thing():
    assert {name: modules for name, modules in defined(ast.ClassDef).items() if len(modules) > 1} == {}


def test_a_public_function_name_means_one_thing():
    """Commands are called as what they call."""
    several = {
        name: modules
        for name, modules in defined(ast.FunctionDef).items()
        if len([module for module in modules if not module.startswith("cli/")]) > 1
    }
    assert {name: modules for name, modules in several.items() if name not in SHARED_NAMES} == {}


@pytest.mark.parametrize(
    "package", sorted(path.parent.relative_to(SRC).as_posix() for path in SRC.rglob("__init__.py"))
)
def test_no_module_is_shadowed_by_an_object_of_its_name(package):
    folder = SRC / package
    modules = {path.stem for path in folder.glob("*.py")} | {path.parent.name for path in folder.glob("*/__init__.py")}
    for file in folder.glob("__init__.py*"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                from_here = node.module in (None, f"polydraulic.{package.replace('/', '.')}")  # the modules themselves
                names = {alias.asname or alias.name for alias in node.names}
                assert from_here or not names & modules, names & modules
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                assert node.name not in modules


def place_of(module):
    """Where the tests of a module belong."""
    path = Path(module)
    return (path.parent / f"test_{path.stem.lstrip('_')}.py").as_posix()


def listed(module):
    return next(
        (entry for entry in TESTED_ELSEWHERE if module == entry or (module.startswith(entry) and entry[-1] == "/")),
        None,
    )


def test_tests_mirror_the_modules_or_say_why_not():
    code = [name for name in MODULES if Path(name).name not in ("__init__.py", "__main__.py")]
    here = {module for module in code if (TESTS / place_of(module)).exists()}
    assert [module for module in code if module not in here and listed(module) is None] == []
    needed = {listed(module) for module in code if module not in here}
    assert [entry for entry in TESTED_ELSEWHERE if entry not in needed] == []
    assert len(here) > 0.7 * len(code)


@pytest.mark.parametrize("entry", TESTED_ELSEWHERE)
def test_tests_that_stand_elsewhere_are_there(entry):
    place, why = TESTED_ELSEWHERE[entry]
    assert (TESTS / place).exists()
    assert why


def test_modules_with_kernels_are_tested_in_plain_python_too():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8").replace("\\\n", " ")
    plain = re.search(r"^PLAIN := (.*)$", makefile, re.MULTILINE)[1].split()
    assert all((ROOT / entry).exists() for entry in plain)
    kernels = [
        m for m in MODULES if re.search(r"^@(kernel|driver)\b", (SRC / m).read_text(encoding="utf-8"), re.MULTILINE)
    ]
    assert "machine/hose.py" in kernels
    for module in kernels:
        place = place_of(module) if (TESTS / place_of(module)).exists() else TESTED_ELSEWHERE[listed(module)][0]
        assert any(f"tests/{place}".startswith(entry) for entry in plain), module
