"""Kinds of faults named by signatures and by abductive networks, of machines watched by few sensors: ``python benchmarks/watch_networks.py``.

``[MACHINE ...] [--seeds N] [--every N] [--keep FOLDER]``: machines, faults and occasions as in ``watch.py``. Networks are learnt from simulated
faults of the identified machine. What they read was chosen on operators from 41000 on of cat215b+~; those from 8600 on chose nothing.
"""

import argparse
from collections import Counter
from pathlib import Path

from polydraulic.identification.watching.fault_networks import learn_fault_networks
from polydraulic.thesis.diagnosis_study import fault_kind, faults_watched, watch_fault
from polydraulic.watch.watch import FREEZE
from show import table
from watch import learnt, say

FIRST_SEED = 8600


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("machines", nargs="*", default=["cat215b+~"])
    parser.add_argument("--seeds", type=int, default=1, help="operators for each fault")
    parser.add_argument("--every", type=int, default=1, help="of the catalogue's faults every so many only")
    parser.add_argument("--keep", type=Path, help="folder of machines that were identified, for the next time")
    options = parser.parse_args()
    rows, named = [], {"signatures": Counter(), "networks": Counter()}
    for name in options.machines:
        case = learnt(name, options.keep)
        networks = learn_fault_networks(case.of, case.expected)
        say(f"{name}: learnt networks of {', '.join(networks.kinds)}")
        found = []
        for kind in [kind for kind in faults_watched(case) if not kind.name.endswith(FREEZE)][:: options.every]:
            for seed in range(FIRST_SEED, FIRST_SEED + options.seeds):
                found.append(watch_fault(case, kind, seed, networks))
                say(f"  {name} {seed}: {found[-1]}")
        alarmed = [f for f in found if f.opinion]
        right = {
            "signatures": [fault_kind(f.named) == fault_kind(f.fault) for f in alarmed],
            "networks": [f.opinion == fault_kind(f.fault) for f in alarmed],
        }
        agree = [all(both) for both in zip(*right.values(), strict=True)]
        either = [any(both) for both in zip(*right.values(), strict=True)]
        rows.append(
            [name, str(len(found)), str(len(alarmed)), *(str(sum(r)) for r in (*right.values(), agree, either))]
        )
        for f in alarmed:
            named["signatures"][fault_kind(f.fault), fault_kind(f.named)] += 1
            named["networks"][fault_kind(f.fault), f.opinion] += 1
    heads = ["machine", "faults", "alarms", "kind named by signatures", "by networks", "by both", "by one of them"]
    table("Kinds of faults in their smallest sizes, by few sensors", heads, rows)
    kinds = sorted({kind for counts in named.values() for kind, _ in counts})
    confusion = [[kind, *(_words(counts, kind) for counts in named.values())] for kind in kinds]
    table("What each kind was named, and how often", ["kind", *named], confusion)


def _words(counts, kind):
    return ", ".join(f"{name} {n}" for (true, name), n in counts.most_common() if true == kind)


if __name__ == "__main__":
    main()
