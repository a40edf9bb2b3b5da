"""What the wrench of a payload lacks beside a rigid body behind an ideal sensor: sought, judged, named or refused.

- `effect`, `sensor_effects`, `hanging`: what may be missing
- `stretch`, `fit`: logs in equal stretches; one more effect fitted beside all else
- `search`: round by round; `at_rest`: what postures alone say
- `doubt`, `words`: what it does to the estimates, and how it is said
"""
