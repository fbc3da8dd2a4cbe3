"""A time series in one file of VTKHDF, which ParaView reads from version 5.12 on.

The layout is that of the VTK file formats, "VTKHDF, UnstructuredGrid, temporal data": one mesh, of
which the cells are kept once, and points and data of all times one after the other.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from bilayer.exports.shapes import Data, MeshData

if TYPE_CHECKING:
    import h5py

VERSION = (2, 0)
CELLS = {"triangle": (5, [0, 1, 2]), "tetra": (10, [0, 1, 2, 3]), "wedge": (13, [0, 2, 1, 3, 5, 4])}
"""VTK's numbers of the kinds of cells, and its order of their points: the first triangle of a wedge
is turned outward."""
COMPRESSED: dict[str, Any] = {"compression": "gzip", "compression_opts": 4, "shuffle": True}


def write_vtkhdf(path: Path, shapes: Iterable[MeshData], times: Sequence[float]) -> None:
    """Write shapes as one series.

    Parameters
    ----------
    path : Path
        The file.
    shapes : iterable of MeshData
        One for each time, all with the same cells and the same names of data.
    times : sequence of float
        Rising.

    Raises
    ------
    ComputationError
        h5py is missing.
    """
    with _h5py().File(path, "w") as file:
        series = _Series(file.create_group("VTKHDF"), np.array(times, dtype=float))
        for number, shape in enumerate(shapes):
            if number == 0:
                series.begin(shape)
            series.add(number, shape)


def _h5py() -> Any:
    try:
        import h5py
    except ImportError as error:
        raise ComputationError(
            f".vtkhdf needs the package h5py ({error}): pip install 'bilayer-shells[viewers]', or "
            "write a .pvd"
        ) from error
    return h5py


class _Series:
    """The group of a file that is being written."""

    def __init__(self, root: "h5py.Group", times: NDArray[np.float64]) -> None:
        self._root, self._times = root, times
        root.attrs["Version"] = VERSION
        root.attrs.create("Type", b"UnstructuredGrid", dtype="S16")

    def begin(self, shape: MeshData) -> None:
        """Write the cells, and make room for the points and the data of all times."""
        root, count = self._root, len(self._times)
        kind, order = CELLS[shape.kind]
        cells = np.asarray(shape.cells, dtype=np.int64)[:, order]
        for name, value in {
            "NumberOfPoints": len(shape.points),
            "NumberOfCells": len(cells),
            "NumberOfConnectivityIds": cells.size,
        }.items():
            root[name] = np.array([value], dtype=np.int64)
        root.create_dataset("Connectivity", data=cells.ravel(), **COMPRESSED)
        root["Offsets"] = cells.shape[1] * np.arange(len(cells) + 1, dtype=np.int64)
        root["Types"] = np.full(len(cells), kind, dtype=np.uint8)
        self._make_room("Points", shape.points)
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = count
        steps["Values"] = self._times
        steps["NumberOfParts"] = np.ones(count, dtype=np.int64)
        for name in ("PartOffsets", "CellOffsets", "ConnectivityIdOffsets"):
            steps[name] = np.zeros(count if name == "PartOffsets" else (count, 1), dtype=np.int64)
        places = np.arange(count, dtype=np.int64)
        steps["PointOffsets"] = len(shape.points) * places
        for group, data in _groups(shape):
            for name, values in data.items():
                self._make_room(f"{group}/{name}", values)
                steps[f"{group}Offsets/{name}"] = len(values) * places

    def add(self, number: int, shape: MeshData) -> None:
        """Write the points and the data of one time."""
        self._put("Points", number, shape.points)
        for group, data in _groups(shape):
            for name, values in data.items():
                self._put(f"{group}/{name}", number, values)

    def _make_room(self, name: str, values: NDArray[Any]) -> None:
        shape = (len(values) * len(self._times), *values.shape[1:])
        self._root.create_dataset(
            name, shape, values.dtype, chunks=tuple(map(max, values.shape, (1,) * values.ndim)),
            **COMPRESSED,
        )  # fmt: skip

    def _put(self, name: str, number: int, values: NDArray[Any]) -> None:
        count = len(values)
        self._root[name][number * count : (number + 1) * count] = values


def _groups(shape: MeshData) -> tuple[tuple[str, Data], tuple[str, Data]]:
    return ("PointData", shape.point_data), ("CellData", shape.cell_data)
