"""Component physics: equations and kernels, no choice of solution method.

In the order of a step: `state`, `pilot` (voltage -> spool), `valve` and `pump` (orifices, closed-form flow), `hose`
(net flow -> pressure), `actuator` (lever arm, friction, stops), `linkage` (motion); `plant` prepares the parameters.
"""

from polydraulic.machine.linkage import end_effector, end_effector_printed
from polydraulic.machine.plant import Plant, prepare
from polydraulic.machine.state import Links, State, initial_state

__all__ = ["Links", "Plant", "State", "end_effector", "end_effector_printed", "initial_state", "prepare"]
