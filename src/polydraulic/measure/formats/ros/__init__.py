"""Bags of ROS: topics whose messages hold numbers, as groups of a log."""
