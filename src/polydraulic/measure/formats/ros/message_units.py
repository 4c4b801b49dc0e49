"""Units of the numbers in standard messages of ROS, as the comments of their definitions give them."""

from typing import NamedTuple


class MessageUnit(NamedTuple):
    """Unit of a field, and another one that its definition allows."""

    unit: str = ""
    other: str = ""


_M, _RAD = MessageUnit("m"), MessageUnit("rad")
_MOTION = {"linear": MessageUnit("m/s"), "angular": MessageUnit("rad/s")}
_INERTIA = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), MessageUnit("kg m2"))
_XYZ = dict.fromkeys("xyz", _M)

# A field that is a message gives its unit to all numbers in it. Efforts are N m, N or whatever the driver has: nobody knows.
_UNITS = {
    "sensor_msgs/msg/JointState": {"position": MessageUnit("rad", "m"), "velocity": MessageUnit("rad/s", "m/s")},
    "sensor_msgs/msg/FluidPressure": {"fluid_pressure": MessageUnit("Pa(a)", "Pa")},
    "sensor_msgs/msg/Temperature": {"temperature": MessageUnit("degC")},
    "sensor_msgs/msg/Imu": {"angular_velocity": MessageUnit("rad/s"), "linear_acceleration": MessageUnit("m/s2")},
    "sensor_msgs/msg/Range": {"range": _M, "min_range": _M, "max_range": _M, "field_of_view": _RAD},
    "sensor_msgs/msg/NavSatFix": {"latitude": MessageUnit("deg"), "longitude": MessageUnit("deg"), "altitude": _M},
    "sensor_msgs/msg/BatteryState": {
        "voltage": MessageUnit("V"),
        "current": MessageUnit("A"),
        "temperature": MessageUnit("degC"),
        "charge": MessageUnit("Ah"),
        "capacity": MessageUnit("Ah"),
        "design_capacity": MessageUnit("Ah"),
    },
    "geometry_msgs/msg/Point": _XYZ,
    "geometry_msgs/msg/Point32": _XYZ,
    "geometry_msgs/msg/Pose2D": {"x": _M, "y": _M, "theta": _RAD},
    "geometry_msgs/msg/Transform": {"translation": _M},
    "geometry_msgs/msg/Twist": _MOTION,
    "geometry_msgs/msg/Accel": {"linear": MessageUnit("m/s2"), "angular": MessageUnit("rad/s2")},
    "geometry_msgs/msg/Wrench": {"force": MessageUnit("N"), "torque": MessageUnit("N m")},
    "geometry_msgs/msg/Inertia": {"m": MessageUnit("kg"), "com": _M, **_INERTIA},
}


def unit_of(kind: str, name: str, outside: MessageUnit) -> MessageUnit:
    """Unit of a field of a message type; that of the field the message stands in comes first."""
    return outside if outside.unit else _UNITS.get(kind, {}).get(name, MessageUnit())
