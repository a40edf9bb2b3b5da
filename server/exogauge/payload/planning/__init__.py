"""Planning: postures and motion that tell most of a payload, within what the robot and its cell allow.

- `workspace`, `arm`: what is allowed, and the arm with what it carries
- `postures`: at rest
- `excitation`: in motion, by the search of `experiment.series_search`
- `plan`: payload.yaml in, files out
"""
