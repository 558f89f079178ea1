"""Independent checks of recorded motions: no code of the planner, Pinocchio's and Coal's own packages instead."""
