"""Work that takes time: one recipe per job kind, and the engine that runs them in workers.

- `recipes`, `requests`, `turns`: what there is to do, asked for, whose turn it is
- `engine`, `bell`, `claims`, `leases`, `code_version`: the queue, who is rung for, who has taken what, and for how long
- `worker`, `attempt`, `compute`, `child`: one job, in a process of its own
- `plans_beside`: what is laid beside a study for it
- `supervisor`: workers are kept alive
- `schema`: the tables of a database, made or brought to this version
"""
