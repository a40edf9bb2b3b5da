"""Whose turn it is: the order in which workers take jobs, which is also the place that a user is told.

Labs take turns: next is the lab of which a job was begun the longest ago, with its oldest job. So a lab that hands in
one job waits for one job of each other lab, however many they handed in, and no job of a lab is overtaken by its newer
ones.
"""

from __future__ import annotations

import sqlalchemy as sa
from sqlalchemy.orm import Session, aliased

from exogauge.storage.scope import OF_ALL_LABS
from exogauge.storage.tables import Job, WorkerLease


def held_by_nobody() -> sa.ColumnElement[bool]:
    """The job's worker holds no lease: it died, or left."""
    return Job.worker.is_(None) | Job.worker.not_in(sa.select(WorkerLease.worker_id))


def free() -> sa.ColumnElement[bool]:
    """Queued, or left running by a worker that is gone."""
    return (Job.state == "queued") | ((Job.state == "running") & held_by_nobody())


def attended() -> sa.ColumnElement[bool]:
    """Runs at a worker that lives."""
    return (Job.state == "running") & ~held_by_nobody()


def in_turn() -> sa.Subquery:
    """Free jobs of all labs: `id`, and `ahead`, how many are taken before it."""
    age = (Job.created_at, Job.id)
    mine = sa.func.row_number().over(partition_by=Job.lab_id, order_by=age).label("round")
    waiting = sa.select(Job.id, Job.lab_id, Job.created_at, mine).where(free()).subquery()
    of_lab = aliased(Job)
    served = sa.select(sa.func.max(of_lab.started_at)).where(of_lab.lab_id == waiting.c.lab_id).scalar_subquery()
    queue = sa.select(waiting, served.label("served")).subquery()
    turn = (queue.c.round, queue.c.served.asc().nulls_first(), queue.c.created_at, queue.c.id)
    return sa.select(queue.c.id, (sa.func.row_number().over(order_by=turn) - 1).label("ahead")).subquery()


def next_jobs(session: Session, most: int) -> list[str]:
    """Ids of the jobs that are to be taken next, in order, of all labs."""
    queue = in_turn()
    query = sa.select(queue.c.id).order_by(queue.c.ahead).limit(most)
    return list(session.scalars(query, execution_options=OF_ALL_LABS))
