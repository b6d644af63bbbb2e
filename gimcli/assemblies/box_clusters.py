"""Boxes that touch, put together: a double root leaves hundreds of boxes, a continuum many thousands."""

from __future__ import annotations

import numpy as np

from gimcli.assemblies.contraction import TURN
from gimcli.mechanism import FloatArray, IntArray

GAP = 1e-12
"""Rounding of neighbouring bounds [rad, lengths of the normal frame]: boxes so near touch."""


def hulls(boxes: FloatArray, angles: int) -> FloatArray:
    """Return the hulls (M, 2, d) of groups of boxes (K, 2, d) that touch, angles around the circle."""
    if not len(boxes):
        return boxes
    label = _touching(boxes, angles)
    result = []
    for group in range(label.max() + 1):
        own = boxes[label == group].copy()
        middle = own.mean(axis=1)[:, :angles]
        own[:, :, :angles] -= (TURN * np.round((middle - middle[0]) / TURN))[:, None]
        result.append([own[:, 0].min(axis=0), own[:, 1].max(axis=0)])
    return np.array(result)


def _touching(boxes: FloatArray, angles: int) -> IntArray:
    """Return the number of each box's group; boxes as wide as the widest are compared with their neighbours only."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    middle, half = boxes.mean(axis=1), 0.5 * (boxes[:, 1] - boxes[:, 0])
    around = np.exp(1j * middle[:, :angles])
    tree = cKDTree(np.hstack([around.real, around.imag, middle[:, angles:]]))
    pairs = tree.query_pairs(2.0 * half.max() + GAP, p=np.inf, output_type="ndarray")
    apart = np.abs(middle[pairs[:, 0]] - middle[pairs[:, 1]])
    apart[:, :angles] = np.abs(apart[:, :angles] - TURN * np.round(apart[:, :angles] / TURN))
    pairs = pairs[np.all(apart <= half[pairs[:, 0]] + half[pairs[:, 1]] + GAP, axis=1)]
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(boxes), len(boxes)))
    return np.asarray(connected_components(graph, directed=False)[1])
