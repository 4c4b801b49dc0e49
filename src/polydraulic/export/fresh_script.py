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


def fmu_answers(job: dict[str, Any]) -> dict[str, Any]:
    """An FMU that is unpacked, through FMPy."""
    import fmpy

    version, kind, place = job["version"], job["fmi_type"], job["place"]
    fmu = fmpy.instantiate_fmu(place, fmpy.read_model_description(place), fmi_type=kind)
    put, get = (fmu.setReal, fmu.getReal) if version == 2 else (fmu.setFloat64, fmu.getFloat64)
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
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


def main() -> None:
    """Read a job from the file that is named first, write its answers to the second."""
    with open(sys.argv[1], encoding="utf-8") as file:
        job = json.load(file)
    answers = {"python": python_answers, "fmu": fmu_answers, "onnx": onnx_answers}[job["kind"]](job)
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        json.dump(answers, file)


if __name__ == "__main__":
    main()
