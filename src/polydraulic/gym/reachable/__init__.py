"""Where a machine can be: `kinematics`, `travels` of joints, `lines`, and all of it as a `workspace`."""
