"""A CAN bus and its databases for tests, and logs of it in every format."""

import numpy as np

DBC = """VERSION ""
BU_: ECU
BO_ 256 Valve: 8 ECU
 SG_ spool : 12|13@1- (0.01,0) [-40|40] "mm" ECU
 SG_ p_head : 28|11@0- (0.5,10) [0|0] "bar" ECU
 SG_ mode : 36|2@1+ (1,0) [0|3] "" ECU
 SG_ temp : 40|8@1+ (0.4,-40) [0|0] "degC" ECU
 SG_ late : 56|8@1+ (1,0) [0|0] "V" ECU
BO_ 2566844672 Engine: 8 ECU
 SG_ speed : 24|16@1+ (0.125,0) [0|8031.875] "rpm" ECU
 SG_ torque : 8|8@1+ (1,-125) [-125|125] "%" ECU
 SG_ brake : 0|2@1+ (1,0) [0|3] "" ECU
 SG_ gear : 4|4@1+ (1,0) [0|15] "" ECU
BO_ 512 Multi: 8 ECU
 SG_ page M : 0|4@1+ (1,0) [0|0] "" ECU
 SG_ a m0 : 8|16@1- (0.1,0) [0|0] "bar" ECU
 SG_ inner m1M : 4|4@1+ (1,0) [0|0] "" ECU
 SG_ b m2 : 15|16@0+ (1,0) [0|0] "mV" ECU
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_ "VFrameFormat" BO_ 2566844672 3;
VAL_ 256 mode 0 "off" 1 "on" 2 "float" 3 "error" ;
VAL_ 256 temp 254 "sensor broken" 255 "no sensor" ;
SG_MUL_VAL_ 512 a page 0-0;
SG_MUL_VAL_ 512 inner page 1-1;
SG_MUL_VAL_ 512 b inner 2-3, 5-5;
"""
LONG = """VERSION ""
BU_: ECU
BO_ 2566852606 Long: 20 ECU
 SG_ first : 0|16@1+ (0.1,0) [0|0] "bar" ECU
 SG_ last : 152|8@1+ (1,0) [0|0] "rpm" ECU
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_DEF_ "VFrameFormat" "J1939PG";
"""
LONG_GROUP = 0xFF0F  # of J1939, of the message in it
ENGINE = 0x18FEF117  # another priority and sender than in the database, as on any real bus


def bus(n=400, seed=1):
    """Frames as (time, identifier, extended, bytes), 4 to a time step."""
    rng = np.random.default_rng(seed)
    frames = []
    for k in range(n):
        valve = rng.integers(0, 256, 8, dtype=np.uint8).tobytes()
        engine = bytearray(rng.integers(0, 250, 8, dtype=np.uint8).tobytes())
        if k % 10 == 3:
            engine[3:5], engine[1] = b"\xff\xff", 0xFE
        if k % 10 == 5:
            engine[3:5] = b"\x12\xfe"
        multi = bytearray(rng.integers(0, 256, 8, dtype=np.uint8).tobytes())
        multi[0] = (k % 3) | rng.integers(0, 8) << 4
        valve = valve[:7] if k % 50 == 7 else valve
        frames.append((0.01 * k, 256, False, valve))
        frames.append((0.01 * k + 0.001, ENGINE, True, bytes(engine)))
        frames.append((0.01 * k + 0.002, 512, False, bytes(multi)))
        frames.append((0.01 * k + 0.003, 0x7FF, False, b"\x01\x02"))
    return frames


def in_parts(time, group, data, source=3, destination=255, kind=32):
    """A message of J1939 in frames of 8 bytes: by broadcast (32), or as requested (16) of one destination."""
    parts = [data[k : k + 7].ljust(7, b"\xff") for k in range(0, len(data), 7)]
    announced = bytes([kind, len(data) & 0xFF, len(data) >> 8, len(parts), 0xFF, *group.to_bytes(3, "little")])
    frames = [(time, 0x1CEC0000 | destination << 8 | source, True, announced)]
    for number, part in enumerate(parts, 1):
        frames.append((time + 0.001 * number, 0x1CEB0000 | destination << 8 | source, True, bytes([number]) + part))
    return frames


def long_message(k):
    """20 bytes of the message of `LONG`: `first` is k / 10 bar, `last` is k rpm."""
    return int(k).to_bytes(2, "little") + bytes(17) + bytes([k])


def write_bus(path, frames):
    """Write frames as .mf4, .blf or .asc."""
    if path.suffix != ".mf4":
        import can

        with (can.BLFWriter if path.suffix == ".blf" else can.ASCWriter)(str(path)) as writer:
            for time, frame, extended, data in frames:
                writer.on_message_received(
                    can.Message(1.7e9 + time, frame, extended, channel=0, data=data, dlc=len(data))
                )
        return path
    from asammdf import MDF, Signal
    from asammdf.blocks.source_utils import Source
    from asammdf.blocks.v4_constants import BUS_TYPE_CAN, FLAG_CG_BUS_EVENT, SOURCE_BUS

    kind = [
        ("BusChannel", "u1"),
        ("ID", "<u4"),
        ("IDE", "u1"),
        ("DLC", "u1"),
        ("DataLength", "u1"),
        ("DataBytes", "(8,)u1"),
    ]
    rows = np.zeros(len(frames), dtype=[(f"CAN_DataFrame.{part}", *rest) for part, *rest in kind])
    for row, (_, frame, extended, data) in zip(rows, frames, strict=True):
        whole = np.frombuffer(data.ljust(8, b"\0"), dtype=np.uint8)
        row["CAN_DataFrame.BusChannel"], row["CAN_DataFrame.ID"], row["CAN_DataFrame.IDE"] = 1, frame, extended
        row["CAN_DataFrame.DLC"] = row["CAN_DataFrame.DataLength"] = len(data)
        row["CAN_DataFrame.DataBytes"] = whole
    source = Source("CAN", "CAN", "", SOURCE_BUS, BUS_TYPE_CAN)
    with MDF(version="4.11") as file:
        file.append(
            Signal(rows, np.array([f[0] for f in frames]), name="CAN_DataFrame", source=source), acq_source=source
        )
        file.groups[-1].channel_group.flags |= FLAG_CG_BUS_EVENT
        file.save(path, overwrite=True)
    return path
