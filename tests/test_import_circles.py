"""No two modules import each other, directly or around a corner: whoever reads one never has to read in a circle."""

from __future__ import annotations

import grimp
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


def test_no_module_imports_itself_around_a_corner() -> None:
    graph = grimp.build_graph("exogauge", cache_dir=None)
    modules = sorted(graph.modules)
    place = {module: number for number, module in enumerate(modules)}
    edges = [(place[a], place[b]) for a in modules for b in graph.find_modules_directly_imported_by(a)]
    importer, imported = np.transpose(edges)
    links = coo_array((np.ones(len(edges)), (importer, imported)), shape=(len(modules), len(modules)))
    _, circle = connected_components(links, directed=True, connection="strong")
    counts = np.bincount(circle)
    found = [
        {modules[k].removeprefix("exogauge.") for k in np.flatnonzero(circle == number)}
        for number in np.flatnonzero(counts > 1)
    ]
    assert len(edges) > len(modules)
    assert found == []
