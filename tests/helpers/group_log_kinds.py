"""What MDF, MAT, CAN and ROS logs look like out there, and what is to come of each: the tests run it, the documentation lists it."""

import numpy as np

from helpers import bag_made
from helpers.can_made import DBC, LONG, LONG_GROUP, bus, in_parts, long_message, write_bus
from helpers.mat_made import opaque

TIME = np.arange(60) * 0.01
PRESSURE = np.round(100.0 + 10.0 * np.sin(20.0 * TIME), 3)
RAW = (10.0 * PRESSURE).astype(np.uint16)
LEAST = np.where(np.arange(60) == 30, np.iinfo(np.int64).min, np.arange(60))
READ, REFUSED = "read", "refused"
MARKED = "<!-- what MDF, MAT, CAN and ROS logs hold -->"


def mdf(*groups, version="4.10", master=None, dbc=False, ending="mf4"):
    """Write an MDF file of groups: lists of (name, values, conversion) or a bus."""

    def write(folder):
        from asammdf import MDF, Signal
        from asammdf.blocks.conversion_utils import from_dict

        with MDF(version=version) as file:
            for n, group in enumerate(groups):
                more = {} if master is None else {"master_metadata": master}
                signals = [
                    Signal(v, TIME[: len(v)], "bar", name, conversion=c and from_dict(nested(c)), **more)
                    for name, v, c in group
                ]
                file.append(signals, acq_name=f"group{n}", common_timebase=True)
            return file.save(folder / f"log.{ending}").rename(folder / f"log.{ending}")

    def nested(conversion):
        return {k: from_conversion(v) if isinstance(v, dict) else v for k, v in conversion.items()}

    def from_conversion(conversion):
        from asammdf.blocks.conversion_utils import from_dict

        return from_dict(conversion)

    return write


def v5(**items):
    def write(folder):
        from scipy.io import savemat

        savemat(folder / "log.mat", items)
        return folder / "log.mat"

    return write


def with_object(kind, **items):
    """Write a file of arrays and of an object, as MATLAB does."""

    def write(folder):
        path = v5(**items)(folder)
        with path.open("ab") as file:
            file.write(opaque("tt", kind, compressed=True))
        return path

    return write


def v73(**items):
    """Write a file of arrays, or of (values, attributes)."""

    def write(folder):
        import h5py

        with h5py.File(folder / "log.mat", "w") as file:
            for name, item in items.items():
                values, attributes = item if isinstance(item, tuple) else (item, {})
                file[name.replace("__", "/")] = values
                file[name.replace("__", "/")].attrs.update(attributes)
        return folder / "log.mat"

    return write


def can(ending, **changes):
    return lambda folder: write_bus(folder / f"log.{ending}", bus(60, **changes))


def bag(storage="mcap", place="", more=(), without="", **changes):
    """Write a bag; the folder, or the file in it that `place` names, without the file `without`."""

    def write(folder):
        make = bag_made.Messages(storage == "bag")
        others = [(f"/{n}", kind, bag_made.BEGAN, make.of(kind, *values)) for n, (kind, *values) in enumerate(more)]
        end = ".bag" if storage == "bag" else ""
        path = bag_made.write_bag(folder / f"log{end}", [*bag_made.work(make, **changes), *others], storage, make)
        if without:
            (path / without).unlink()
        return path / place if place else path

    return write


def journal(folder):
    path = bag("db3")(folder)
    (path / "log.db3-wal").write_bytes(b"frames")
    return path


def nothing_but_texts(folder):
    text = bag_made.Messages().of("std_msgs/msg/String", "on")
    return bag_made.write_bag(folder / "log", [("/state", "std_msgs/msg/String", bag_made.BEGAN, text)])


def several_frames(lost=()):
    """Write a bus on which messages of J1939 take several frames, some of which may be lost."""

    def write(folder):
        frames = [f for k, t in enumerate(TIME) for f in in_parts(10.0 * t, LONG_GROUP, long_message(k))]
        return write_bus(folder / "log.blf", [frame for n, frame in enumerate(frames) if n not in lost])

    return write


def cut(make, share):
    def write(folder):
        path = make(folder)
        path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
        return path

    return write


SCALE = {"a": 0.1, "b": 0.0}
CODES = {"val_0": int(RAW[7]), "text_0": "error", "default_addr": SCALE}
RANGES = {"lower_0": 1080, "upper_0": 1200, "text_0": "not available", "default_addr": SCALE}
STATES = {"val_0": 0, "text_0": "off", "val_1": 1, "text_1": "on"}
PLAIN = mdf([("p", PRESSURE, None)])
BOTH = {"time": TIME, "p": PRESSURE}
SIGNALS = {"values": PRESSURE, "label": "p"}

# group -> what it is -> (function of a folder that writes it, channel that is read, what comes of it[, databases])
KINDS = {
    "MDF": {
        "MDF 4": (PLAIN, "p", READ),
        "MDF 3, MDF 2 (`.mdf`, `.dat`)": (mdf([("p", PRESSURE, None)], version="3.30", ending="dat"), "p", READ),
        "codes with texts beside a scaling": (mdf([("p", RAW, CODES)]), "p", ("status",)),
        "ranges of texts beside a scaling": (mdf([("p", RAW, RANGES)]), "p", ("status",)),
        "names of states without a scaling: their numbers": (mdf([("p", RAW % 2, STATES)]), "p", READ),
        "one name in two groups: `p`, `group1/p`": (mdf([("p", PRESSURE, None)], [("p", PRESSURE, None)]), "group1/p", READ),
        "the first of two of one name, as `p`": (mdf([("p", PRESSURE, None)], [("p", PRESSURE, None)]), "p", ("duplicate",)),
        "the least 64-bit integer among others": (mdf([("p", LEAST, None)]), "p", ("infinite",)),
        "a group without rows beside others": (mdf([("p", PRESSURE, None)], [("q", PRESSURE[:0], None)]), "p", ("not read",)),
        "a group over an angle, a distance or an index": (mdf([("p", PRESSURE, None)], master=("crank", 2)), "p", REFUSED),
        "a formula of `+`, `-`, `*`, `/` and brackets": (mdf([("p", RAW, {"formula": "X1*0.1"})]), "p", READ),
        "other formulas beside channels without": (mdf([("p", PRESSURE, None), ("q", RAW, {"formula": "sqrt(X1)"})]), "p", ("not read",)),
        "a raw bus log without databases": (can("mf4"), "p_head", REFUSED),
        "cut off": (cut(PLAIN, 0.5), "p", REFUSED),
    },
    "MAT": {
        "vectors, matrices and structures, v5 to v7": (v5(**BOTH), "p", READ),
        "vectors, matrices and structures, v7.3": (v73(**BOTH), "p", READ),
        "Simulink's structure with time, v5 to v7": (v5(out={"time": TIME, "signals": SIGNALS}), "out.signals.values", READ),
        "Simulink's structure with time, v7.3": (
            v73(out__time=TIME[None], out__signals__values=PRESSURE[None]), "out.signals.values", READ),
        "empty arrays, sparse and complex matrices, cells beside others": (v5(**BOTH, empty=np.zeros((0, 3))), "p", ("not read",)),
        "texts, one for each row, beside others": (v5(**BOTH, state=np.array(["on", "off"] * 30)), "p", ("not read",)),
        "the least 64-bit integer among others": (v5(time=TIME, p=LEAST), "p", ("infinite",)),
        "objects (timetable, timeseries, string), v5 to v7": (with_object("timetable", **BOTH), "p", ("not read",)),
        "objects (timetable, timeseries, string), v7.3": (
            v73(**BOTH, tt=(np.ones((1, 6), dtype=np.uint32), {"MATLAB_class": b"timetable", "MATLAB_object_decode": 3})),
            "p", ("not read",)),
        "objects alone": (
            v73(tt=(np.ones((1, 6), dtype=np.uint32), {"MATLAB_class": b"timetable", "MATLAB_object_decode": 3})), "tt", REFUSED),
        "cut off": (cut(v73(**BOTH), 0.5), "p", REFUSED),
    },
    "CAN, with `--dbc`": {
        "MDF 4 bus logging": (can("mf4"), "p_head", READ),
        "BLF": (can("blf"), "p_head", READ),
        "ASC": (can("asc"), "p_head", READ),
        "signed, big-endian, off the grid of bytes": (can("blf"), "p_head", READ),
        "multiplexed, also by a multiplexed signal": (can("blf"), "a", READ),
        "J1939 messages that take several frames (BAM, RTS and CTS)": (several_frames(), "first", READ),
        "such messages, some of whose frames are lost": (several_frames((9, 14)), "first", ("not read",)),
        "J1939 codes: error, not available, reserved, parameter specific": (can("blf"), "speed", ("status",)),
        "values with texts beside a scaling or a unit": (
            lambda folder: write_bus(folder / "log.blf", [(t, 256, False, bytes([0, 0, 0, 0, 0, 254 if k == 9 else k, 0, 0]))
                                                          for k, t in enumerate(TIME)]), "temp", ("status",)),
        "frames shorter than their message": (can("blf"), "late", ("short frame",)),
        "frames without a database are named": (can("blf"), "p_head", ("not read",)),
        "BLF, cut off": (cut(can("blf"), 0.5), "p_head", ("not read",)),
        "MDF 4 or ASC, cut off within a row": (cut(can("mf4"), 0.5), "p_head", REFUSED),
    },
    "ROS": {
        "ROS 2, the folder of a bag, MCAP or SQLite": (bag(), "/pump/fluid_pressure", READ),
        "ROS 2, `.mcap` alone": (bag(place="log.mcap"), "/pump/fluid_pressure", READ),
        "ROS 2, `.db3` alone": (bag("db3", "log.db3"), "pump/fluid_pressure", READ),
        "ROS 1, `.bag`": (bag("bag"), "/pump/fluid_pressure", READ),
        "joint states, each joint by its name": (bag(), "/joint_states/boom.position", READ),
        "numbers without a header, at the times of receipt": (bag(), "/spool/data", READ),
        "headers whose times are not those of receipt": (bag(late=2.0), "/pump/fluid_pressure", ("stamps",)),
        "headers without times": (bag(stamps=lambda t: None), "/pump/fluid_pressure", ("unstamped",)),
        "topics of strings, images, lists of messages beside others": (
            bag(more=[("std_msgs/msg/String", "on"), ("tf2_msgs/msg/TFMessage", [])]), "/pump/fluid_pressure", ("not read",)),
        "what a recorder had not put into its database": (journal, "/pump/fluid_pressure", ("not read",)),
        "topics of strings alone": (nothing_but_texts, "/state/data", REFUSED),
        "a folder without `metadata.yaml`": (bag(without="metadata.yaml"), "/pump/fluid_pressure", REFUSED),
        "cut off": (cut(bag(place="log.mcap"), 0.5), "/pump/fluid_pressure", REFUSED),
    },
}  # fmt: skip


def cases():
    """All of them: (group, what it is, function that writes it, channel, what comes of it)."""
    return [(group, what, *case) for group, of in KINDS.items() for what, case in of.items()]


def databases(folder, group):
    """CAN databases of a case."""
    if not group.startswith("CAN"):
        return ()
    (folder / "bus.dbc").write_text(DBC)
    (folder / "long.dbc").write_text(LONG)
    return folder / "bus.dbc", folder / "long.dbc"


def documented():
    """The table of the documentation."""
    rows = ["| | log | what comes of it |", "|---|---|---|"]
    before = ""
    for group, what, _, _, came in cases():
        said = came if isinstance(came, str) else "read; named as " + ", ".join(f"`{kind}`" for kind in came)
        rows.append(f"| {group if group != before else ''} | {what} | {said} |")
        before = group
    return "\n".join([MARKED, *rows]) + "\n"
