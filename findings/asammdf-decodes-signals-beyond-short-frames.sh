#!/bin/sh
# Title: asammdf decodes a CAN signal that lies beyond the end of a short frame as 0, as if it had been sent.
# Surprise: `MDF.extract_bus_logging` ("Extract all possible CAN signals using the provided databases") should give no sample where a
#   frame does not hold the signal. In the standard (ASAM MDF bus logging) `DataLength` says how many of the `DataBytes` were
#   received; the bytes behind them are padding.
# Versions: asammdf 8.8.28 with canmatrix 1.2.
# What we do: frames are decoded by src/polydraulic/measure/formats/can, which takes such signals as missing and reports them.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet asammdf==8.8.28 canmatrix==1.2 numpy==2.4.6
cat >"$folder/show.py" <<'PYTHON'
import os
import sys
from importlib.metadata import version

import numpy as np
from asammdf import MDF, Signal
from asammdf.blocks.source_utils import Source
from asammdf.blocks.v4_constants import BUS_TYPE_CAN, FLAG_CG_BUS_EVENT, SOURCE_BUS

os.chdir(sys.argv[1])
with open("a.dbc", "w") as file:
    file.write('VERSION ""\nBU_: ECU\nBO_ 256 Message: 8 ECU\n SG_ early : 0|8@1+ (1,0) [0|0] "" ECU\n SG_ late : 56|8@1+ (1,0) [0|0] "" ECU\n')
kind = [("BusChannel", "u1"), ("ID", "<u4"), ("IDE", "u1"), ("DLC", "u1"), ("DataLength", "u1"), ("DataBytes", "(8,)u1")]
rows = np.zeros(4, dtype=[(f"CAN_DataFrame.{part}", *rest) for part, *rest in kind])
rows["CAN_DataFrame.BusChannel"], rows["CAN_DataFrame.ID"] = 1, 256
rows["CAN_DataFrame.DLC"] = rows["CAN_DataFrame.DataLength"] = [8, 7, 8, 7]  # two frames end before the signal does
rows["CAN_DataFrame.DataBytes"][:, 0] = [11, 12, 13, 14]
rows["CAN_DataFrame.DataBytes"][::2, 7] = [101, 103]
source = Source("CAN", "CAN", "", SOURCE_BUS, BUS_TYPE_CAN)
with MDF(version="4.11") as file:
    file.append(Signal(rows, np.arange(4) * 0.1, name="CAN_DataFrame", source=source), acq_source=source)
    file.groups[-1].channel_group.flags |= FLAG_CG_BUS_EVENT
    file.save("a.mf4")
with MDF("a.mf4") as file:
    late = file.extract_bus_logging({"CAN": [("a.dbc", 0)]}).get("Message.late")
print("asammdf", version("asammdf"), "canmatrix", version("canmatrix"), "numpy", np.__version__)
print("described: DataLength bytes were received; frames 2 and 4 do not hold `late`, so two samples, 101 and 103")
print("seen:     ", late.samples.tolist(), "at", late.timestamps.tolist(), "invalid", late.invalidation_bits)
there = late.samples.tolist() == [101, 0, 103, 0] and late.invalidation_bits is None
print("the behaviour is there" if there else "the behaviour has changed")
sys.exit(0 if there else 1)
PYTHON
"$folder/venv/bin/python" "$folder/show.py" "$folder"
