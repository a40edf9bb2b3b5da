"""Motions from which a robot is identified well: planned within every bound, with what they will tell.

- `task`: robot and bounds become what is planned; `search`: the best motion, by `experiment.series_search`
- `excited`: that motion from rest to rest
- `known`, `promise`: what logs say already, and what will be known
- `plan`: robot.yaml in, files out
"""
