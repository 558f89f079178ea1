"""The three experiments of the paper: `srmp bench paper` runs, checks, tabulates and draws them.

(a) one arm solves problems and slight variations of them; (b) several arms do; (c) MotionBenchMaker. Our planners run
beside OMPL's, on the same robot, scene and collision checker, and beside OMPL's with plain Coal.
"""
