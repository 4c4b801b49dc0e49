"""A script as users write it; mypy reads it (tests/test_types.py), nobody runs it.

`assert_type` fails where a name is untyped, and an unused `type: ignore` where a mistake is not seen.
"""

from pathlib import Path
from typing import assert_type

import numpy as np

from polydraulic import (
    AbductiveRegressor,
    Batch,
    Difference,
    LayoutMachine,
    Progress,
    RegionRegressor,
    Scenario,
    Table,
    build_flow,
    compare,
    load_machine,
    load_models,
    load_scenario,
    random_operator,
    read_table,
    simulate,
    simulate_batch,
)
from polydraulic.export import Exported, export_c, export_machine, to_text
from polydraulic.flow import FlowModel, exact_flow
from polydraulic.identification import Check, MachineFit, Replay, TableFit, check_models, fit_machine, fit_table, replay
from polydraulic.measure import ChannelMap, Imported, import_log, load_channels
from polydraulic.networks import Model, Network, Variable, check_range, learn_from, model_bounds
from polydraulic.plotting import plot_run, save_figure

machine = load_machine("cat215b")
assert_type(machine, LayoutMachine)
assert_type(machine.link("boom").mass, float)
assert_type(machine.with_values({"links.boom.mass": 900, "gravity": 9.8}), LayoutMachine)
assert_type(load_scenario("task"), Scenario)
assert_type(random_operator(1, 10.0), Scenario)


def show(what: str, done: int, total: int) -> None:
    """Show how far it is."""


told: Progress = show
run = simulate("cat215b", "exact", "single_08", dt=1e-3)
assert_type(run, Table)
assert_type(run["time"], np.ndarray)
assert_type(list(run), list[str])
assert_type("time" in run, bool)
assert_type(len(run), int)
assert_type(Table.from_dict({"a": [1.0, 2.0]}, {"a": "m"}), Table)
assert_type(read_table(Path("a.csv")), Table)
assert_type(compare(run, run), dict[str, Difference])
assert_type(compare(run, run)["boom.angle"].largest, float)
assert_type(simulate_batch([machine, "cat215b"], "exact", ["task"], progress=show), Batch)
assert_type(simulate_batch(machine, "exact", np.zeros((4, 3))).final, np.ndarray)
assert_type(build_flow("tlm", machine, alpha=0.2), FlowModel)
assert_type(exact_flow("cat215b").name, str)

learner = AbductiveRegressor().fit(run.matrix(["time"]), run["boom.angle"])
assert_type(learner, AbductiveRegressor)
assert_type(learner.predict([[1.0]]), np.ndarray)
assert_type(learner.network_, Network)
assert_type(RegionRegressor(learner, edges={0: [0.5]}).fit([[1.0]], [1.0]).to_model([Variable("t", "s")]), Model)
models = load_models("a.json")
assert_type(models, list[Model])
assert_type(models[0].predict(np.zeros((1, 1))), np.ndarray)
assert_type(model_bounds(models[0]).low, float)
assert_type(check_range(models[0], 0.0, 1.0).holds, bool | None)
assert_type(learn_from(lambda X: X[:, 0], [(0.0, 1.0)], tolerance=0.1).model, Model)

channels = load_channels("map.toml")
assert_type(channels, ChannelMap)
assert_type(import_log("log.csv", channels, "table.parquet", progress=show), Imported)
assert_type(fit_table(run, ["time"], ["boom.angle"]), TableFit)
assert_type(fit_machine("table.parquet", progress=show), MachineFit)
assert_type(replay("table.parquet", machine), Replay)
assert_type(check_models(models), Check)
assert_type(export_c(models, "c"), Exported)
assert_type(export_machine(machine, "exact", "c", name="digger"), Exported)
assert_type(to_text(models[0]), str)
save_figure(plot_run({"exact": run}), "run.svg")

simulate("cat215b", 3, "single_08")  # type: ignore[arg-type]
simulate("cat215b", "exact", "single_08", 1e-3)  # type: ignore[call-arg]
simulate("cat215b", "exact", "single_08", step=1e-3)  # type: ignore[call-arg]
simulate_batch(machine, "exact", "task", progress=lambda done: None)  # type: ignore[arg-type]
machine.with_values({"links.boom.mass": "900 kg"})  # type: ignore[dict-item]
print(machine.link("boom").weight)  # type: ignore[attr-defined]
