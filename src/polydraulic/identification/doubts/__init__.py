"""Channels of a log that contradict each other, whatever each says alone, and sensors that say nothing. Read `channels`, then `stuck`."""
