from .jacobian_policy import follow_goal
from .machine_env import MachineEnv
from .machine_vector_env import MachineVectorEnv

__all__ = ["MachineEnv", "MachineVectorEnv", "follow_goal"]
