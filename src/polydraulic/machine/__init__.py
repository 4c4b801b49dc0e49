"""Component physics: equations and kernels, no choice of solution method.

In the order of a step: `state`, `pilot` (voltage -> spool), `valve` and `pump` (orifices, closed-form flow), `hose`
(net flow -> pressure), `actuator` (lever arm, friction, stops), `linkage` (motion); `plant` prepares the parameters.
`circuits` holds what a pump with more than two valves needs, written out for their number, and circuits that are joined.
"""
