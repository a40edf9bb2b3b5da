"""From a captured human to a motion that a robot can do (steps S1 and S2a of [Evaluator]).

files → human (`HumanMotion`) → fit (the robot's structure, morphed to the person) → retarget → check → exports
"""
