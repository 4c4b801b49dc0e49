"""Runs of cat215b as they were when its step was written by hand, for swing, boom and stick alone.

The numbers are of commit 0193a3c, on 29 November 2026: for each flow model, ``simulate("cat215b", flow, "task", t_end=2.0)``, and for each method
the same with flow "exact"; the last row of COLUMNS. Single steps of both differ by less than 3e-16 of the largest value, which feedback makes no larger;
methods that choose their own steps are as close as their tolerance.
"""

import pytest

from polydraulic import build_flow, simulate

COLUMNS = [
    "swing.angle",
    "boom.angle",
    "stick.angle",
    "boom.p_a",
    "swing.p_a",
    "stick.p_b",
    "boom.q_in",
    "series.q_bypass",
]
FLOWS = {
    "exact": [
        0.12163336029548298,
        0.5967915484358086,
        -1.4176355750697849,
        6245031.13585146,
        4509015.97908968,
        163825.7145944385,
        0.0008315422605068017,
        0.002340041172839704,
    ],
    "iterative": [
        0.12173329987330779,
        0.596794129896339,
        -1.4176355867103736,
        6244535.061785815,
        4504169.379181319,
        163821.0517547795,
        0.0008315360785942144,
        0.002339894827137094,
    ],
    "stiff": [
        0.12147065009068753,
        0.596773451956458,
        -1.4176356739807354,
        6247031.624224582,
        4514938.627795036,
        163783.70352101565,
        0.0008315704019096285,
        0.002341097704814444,
    ],
    "tlm": [
        0.12145902967496822,
        0.5967743749790855,
        -1.4176356883416834,
        6247010.885937864,
        4513593.356516877,
        163777.55441986793,
        0.0008315706013792575,
        0.002341133841249175,
    ],
    "lookup": [
        0.16766874764013592,
        0.5967695614998261,
        -1.4176164171444579,
        6269069.550806727,
        4752238.349106112,
        171937.7340111414,
        0.0008314010351449609,
        0.002222350121972538,
    ],
    "polynomial": [
        0.11978374364396178,
        0.5967925397034171,
        -1.417636213589212,
        6244224.278793436,
        4496952.142924471,
        163555.70033884607,
        0.0008315321706236493,
        0.0023451279351235903,
    ],
    "neural": [
        0.1180476381707253,
        0.5965673508970792,
        -1.417636956105216,
        6241078.436031034,
        4342445.181110739,
        163257.18687084824,
        0.0008299699346073524,
        0.0023548528783609362,
    ],
}
OPTIONS = {"lookup": {"points": 8}}
METHODS = {
    "rk4": [
        0.12049895065554433,
        0.5965109717024982,
        -1.417635391182196,
        6246783.976346472,
        4518392.5381777305,
        163806.3684287681,
        0.0008315631293341012,
        0.0023400142591540798,
    ],
    "rosenbrock": [
        0.1204989632571297,
        0.5965088298342223,
        -1.4176354656643855,
        6247704.572049996,
        4518388.988039218,
        163774.8876935138,
        0.0008315361701039813,
        0.002340013925605211,
    ],
    "reference": [
        0.12049867900756019,
        0.5965109211667836,
        -1.4176353910986106,
        6246783.69125348,
        4518395.176143516,
        163806.40472444321,
        0.0008315631376913555,
        0.002340014506987975,
    ],
}
CLOSE = {"rk4": 1e-10, "rosenbrock": 1e-6, "reference": 1e-6}
QUICK = ("exact", "polynomial")


def last_row(flow, method="semi-implicit"):
    model = build_flow(flow, "cat215b", **OPTIONS.get(flow, {}))
    run = simulate("cat215b", model, "task", t_end=2.0, method=method)
    return [run[name][-1] for name in COLUMNS]


@pytest.mark.parametrize("flow", [pytest.param(f, marks=[] if f in QUICK else pytest.mark.slow) for f in FLOWS])
def test_flow_models_as_they_were(flow):
    assert last_row(flow) == pytest.approx(FLOWS[flow], rel=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_methods_as_they_were(method):
    assert last_row("exact", method) == pytest.approx(METHODS[method], rel=CLOSE[method])
