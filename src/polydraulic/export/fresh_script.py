"""What `export.fresh` copies beside an exported file and gives to an interpreter of its own.

It stands alone and imports nothing of the package: the exported file meets what it meets in a user's program. Points come from one file and
answers go to another, both JSON: ``y`` by rows, and ``slopes`` and ``outside`` if the target has them.
"""

import importlib
import json
import sys
from typing import Any


def python_answers(job: dict[str, Any]) -> dict[str, Any]:
    """Functions of an exported module, each with the columns that it reads."""
    module = importlib.import_module(job["module"])
    functions = [(getattr(module, name), place) for name, place in zip(job["names"], job["places"], strict=True)]
    return {"y": [[function(*(row[i] for i in place)) for function, place in functions] for row in job["X"]]}


def _begun(job: dict[str, Any], kind: str) -> tuple[Any, Any, Any]:
    """An FMU that is unpacked, initialized, and what sets and gets its numbers."""
    import fmpy

    version, place = job["version"], job["place"]
    fmu = fmpy.instantiate_fmu(place, fmpy.read_model_description(place), fmi_type=kind)
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, *((fmu.setReal, fmu.getReal) if version == 2 else (fmu.setFloat64, fmu.getFloat64))


def fmu_rows(job: dict[str, Any]) -> dict[str, Any]:
    """An FMU that runs row by row, through FMPy: answers behind the rows that are measured."""
    fmu, put, get = _begun(job, "CoSimulation")
    n, m, dt = job["n_signals"], job["n_outputs"], job["raster"]
    found = []
    for k, row in enumerate(job["X"]):
        put(list(range(n + 1)), [*row, float(k < job["measured"])])
        fmu.doStep(currentCommunicationPoint=k * dt, communicationStepSize=dt)
        found.append(list(get(list(range(n + 1, n + 1 + m)))))
    fmu.terminate()
    fmu.freeInstance()
    return {"y": found[job["measured"] :]}


def fmu_answers(job: dict[str, Any]) -> dict[str, Any]:
    """An FMU that is unpacked, through FMPy."""
    kind = job["fmi_type"]
    fmu, put, get = _begun(job, kind)
    n, m = job["n_inputs"], job["n_outputs"]
    inputs, outputs = list(range(n)), list(range(n, n + m))
    seeds = [[float(i == k) for i in range(n)] for k in range(n)]
    found: dict[str, list[Any]] = {"y": [], "slopes": [], "outside": []}
    for k, row in enumerate(job["X"]):
        put(inputs, row)
        if kind == "CoSimulation":
            fmu.doStep(currentCommunicationPoint=float(k), communicationStepSize=1.0)
        *y, outside = get([*outputs, n + m])
        columns = [fmu.getDirectionalDerivative(outputs, inputs, seed) for seed in seeds]
        found["y"].append(list(y))
        found["outside"].append(outside)
        found["slopes"].append([[column[j] for column in columns] for j in range(m)])
    fmu.terminate()
    fmu.freeInstance()
    return found


def onnx_answers(job: dict[str, Any]) -> dict[str, Any]:
    """An ONNX graph, through ONNX Runtime."""
    import numpy as np
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3  # errors only
    session = onnxruntime.InferenceSession(job["place"], options, providers=["CPUExecutionProvider"])
    X = np.array(job["X"], dtype=np.float64 if job["real"] == "double" else np.float32)
    y, outside = session.run(["y", "domain"], {"x": X})
    return {"y": y.tolist(), "outside": outside[:, 0].tolist()}


_KINDS = {"python": python_answers, "fmu": fmu_answers, "fmu_rows": fmu_rows, "onnx": onnx_answers}


def main() -> None:
    """Read a job from the file that is named first, write its answers to the second."""
    with open(sys.argv[1], encoding="utf-8") as file:
        job = json.load(file)
    answers = _KINDS[job["kind"]](job)
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        json.dump(answers, file)


if __name__ == "__main__":
    main()
