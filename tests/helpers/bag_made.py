"""Bags of ROS for tests, as rosbags writes them: one working machine, whatever the format."""

import numpy as np
from rosbags.rosbag1 import Writer as OldWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

BEGAN = 1_700_000_000  # s since 1970
TIME = np.round(np.arange(60) * 0.01, 9)
HEAD = 1e5 * np.round(100.0 + 10.0 * np.sin(20.0 * TIME), 3)  # Pa, absolute
PLUGINS = {"mcap": StoragePlugin.MCAP, "db3": StoragePlugin.SQLITE3}
VALVE = "std_msgs/Header header\nstring label\nbool open\nint64 serial\nfloat32[3] current\nfloat64[] pressures\nrig_msgs/Lands lands\n"
LANDS = "string[] name\nfloat64[] wear\n"


def whole_ns(seconds):
    """Nanoseconds of a time that is whole microseconds."""
    return round(seconds * 1e6) * 1000


class Messages:
    """Makes messages of a set of types."""

    def __init__(self, old=False):
        self.store = get_typestore(Stores.ROS1_NOETIC if old else Stores.ROS2_HUMBLE)
        self.store.register(get_types_from_msg(LANDS, "rig_msgs/msg/Lands"))
        self.store.register(get_types_from_msg(VALVE, "rig_msgs/msg/Valve"))
        self.old = old

    def of(self, kind, *values, **named):
        return self.store.types[kind](*values, **named)

    def header(self, seconds):
        """A header with a time; None leaves it 0."""
        ns = 0 if seconds is None else whole_ns(seconds)
        stamp = self.of("builtin_interfaces/msg/Time", ns // 10**9, ns % 10**9)
        return self.of("std_msgs/msg/Header", *([0] if self.old else []), stamp, "base")

    def joints(self, seconds, name, position, velocity=(), effort=()):
        arrays = (np.array(part, dtype=np.float64) for part in (position, velocity, effort))
        return self.of("sensor_msgs/msg/JointState", self.header(seconds), list(name), *arrays)

    def pressure(self, seconds, value):
        return self.of("sensor_msgs/msg/FluidPressure", self.header(seconds), float(value), 0.0)

    def number(self, value):
        return self.of("std_msgs/msg/Float64", float(value))


def work(make, late=0.002, stamps=lambda t: BEGAN + t):
    """Joints and pressure with headers, a spool without: (topic, type, time of receipt in s, message)."""
    for k, t in enumerate(TIME):
        at = BEGAN + t + late
        angles = [0.1 * np.sin(9.0 * t), -0.5 + t]
        names = ["boom", "stick"] if k % 2 else ["stick", "boom"]  # publishers may turn them round
        joints = make.joints(stamps(t), names, angles if k % 2 else angles[::-1], effort=[k, 2 * k])
        yield "/joint_states", "sensor_msgs/msg/JointState", at, joints
        yield "/pump", "sensor_msgs/msg/FluidPressure", at, make.pressure(stamps(t), HEAD[k])
        yield "/spool", "std_msgs/msg/Float64", BEGAN + t, make.number(0.5 * t)


def write_bag(path, messages, storage="mcap", make=None, compressed=None):
    """Write a bag of (topic, type, s since 1970, message): a folder, or a file of ROS 1 where `storage` is ``"bag"``."""
    make = make or Messages(storage == "bag")
    old = storage == "bag"
    bag = OldWriter(path) if old else Writer(path, version=9, storage_plugin=PLUGINS[storage])
    if compressed:
        bag.set_compression(CompressionMode[compressed], CompressionFormat.ZSTD)
    with bag as writer:
        connections = {}
        for topic, kind, seconds, message in messages:
            key = topic, kind
            if key not in connections:
                connections[key] = writer.add_connection(topic, kind, typestore=make.store)
            if message is not None:
                written = (make.store.serialize_ros1 if old else make.store.serialize_cdr)(message, kind)
                writer.write(connections[key], whole_ns(seconds), written)
    return path
