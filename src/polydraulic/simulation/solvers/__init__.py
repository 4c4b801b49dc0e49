"""The other methods of `simulate`, and what they share.

`right_hand_side` is the equations in continuous time; `runge_kutta` the classic method with fixed steps; `rosenbrock` with
`rosenbrock_step`, `jacobian`, `switching` and `spools` an adaptive method that ends its steps at every kink; `lsoda` the judge.
"""
