"""Names under which Gymnasium finds the tasks."""

from polydraulic.gym.arguments import STEPS, TASKS


def register_tasks() -> None:
    """Register ``polydraulic/Reach-v0``, ``polydraulic/Grade-v0`` and ``polydraulic/PickPlace-v0``, single and side by side."""
    import gymnasium

    for task in TASKS:
        name = f"polydraulic/{task}-v0"
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point="polydraulic.gym.machine_env:MachineEnv",
                vector_entry_point="polydraulic.gym.machine_vector_env:MachineVectorEnv",
                max_episode_steps=STEPS[task],
                kwargs={"task": task},
            )
