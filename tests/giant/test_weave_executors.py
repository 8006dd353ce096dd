"""Threads and dask workers make the same bytes; who dies is replaced."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from giant.dying import Dies
from giant.giants import files_below, needs, small
from hypothesis import given, settings
from hypothesis import strategies as st

import intarsia as ia
from intarsia.foundation import InputError, MissingExtraError, ParameterError, ResourceError
from intarsia.giant import zarrays
from intarsia.giant.picture import Grid
from intarsia.giant.stream import by_cluster, by_threads, check_dask


def woven(path: Path, how: str, dask: Any, workers: int = 2, **more: Any) -> dict[str, bytes]:
    texture = small(3)
    getattr(texture, f"to_{how}")(path, (230, 210), origin=(-40, 9), dask=dask, run=ia.Run(workers), **more)
    return files_below(path)


@pytest.fixture
def cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small cells, so that a small picture has several."""
    for module in ("zarrays", "exports"):
        monkeypatch.setattr(f"intarsia.giant.{module}.SIDE", 64)
    monkeypatch.setattr("intarsia.giant.exports.AREA", 64 * 64)


@pytest.mark.usefixtures("cut")
@pytest.mark.parametrize("how", ["zarr", "tiff"])
def test_the_number_of_threads_changes_no_byte(how: str, tmp_path: Path) -> None:
    needs("zarr")
    side = {"chunk": 32} if how == "zarr" else {"tile": 32}
    whole = woven(tmp_path / "a", how, None, 1, **side)
    assert whole == woven(tmp_path / "b", how, None, 3, **side)


@given(st.integers(0, 40), st.integers(1, 5))
def test_threads_keep_the_order(count: int, workers: int) -> None:
    cells = [Grid(64, 64, 8, 8).cell(n) for n in range(count)]
    found = list(by_threads(workers, lambda cell: [bytes([cell.number])], cells))
    assert found == [(cell, [bytes([cell.number])]) for cell in cells]


@pytest.mark.filterwarnings("ignore")
def test_all_kinds_of_processors_in_a_dask_cluster_agree(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, thorough: bool
) -> None:
    """Worker processes make the bytes of this one, those compiled for another processor too; so does a dask array.

    Compiling takes most of the time: only the long run has a worker of the second kind.
    """
    distributed = needs("distributed")
    needs("zarr")
    monkeypatch.setattr(zarrays, "SIDE", 64)
    whole = woven(tmp_path / "a", "zarr", None, 1, chunk=32)
    around = {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p), "OPENBLAS_NUM_THREADS": "1"}
    kinds = ({}, {"NUMBA_CPU_NAME": "generic"} if thorough else {})
    workers = {
        n: {"cls": distributed.Nanny, "options": {"nthreads": 1, "dashboard_address": None, "env": around | kind}}
        for n, kind in enumerate(kinds)
    }
    scheduler = {"cls": distributed.Scheduler, "options": {"dashboard_address": None, "port": 0}}
    with (
        distributed.SpecCluster(workers, scheduler=scheduler, silence_logs=50) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert len(set(client.run(processor).values())) == 1 + thorough
        assert woven(tmp_path / "b", "zarr", client, chunk=32) == whole
        assert woven(tmp_path / "c", "zarr", cluster.scheduler_address, chunk=32) == whole
        array = small(3).to_dask((90, 120), (50, 33), (-20, 2**31 - 50))
        assert (np.asarray(array.compute()) == small(3)[-20:70, 2**31 - 50 : 2**31 + 70]).all()
        shown = client.run(len_of_tasks)
        assert sum(shown.values()) > 0, "both workers must have drawn"


@pytest.mark.filterwarnings("ignore")
def test_a_dask_worker_that_dies_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the other one, which has the texture, too; a cell that every worker dies of is given up."""
    distributed = needs("distributed")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(p for p in sys.path if p))
    cells = list(Grid(40, 10, 2, 10))
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster,
        distributed.Client(cluster) as client,
    ):
        (tmp_path / "once").mkdir()
        found = list(by_cluster(client, Dies(str(tmp_path / "once"), 3, 1), cells))
        assert found == [(cell, [str(cell.number).encode()]) for cell in cells]
        (tmp_path / "always").mkdir()
        with pytest.raises(ResourceError, match="the workers of the cluster died, or none answered for 120 s"):
            list(by_cluster(client, Dies(str(tmp_path / "always"), 3, 99), cells))


def processor() -> str:
    """The processor that a worker compiles for."""
    import numba

    return str(numba.config.CPU_NAME)


def len_of_tasks(dask_worker: Any) -> int:
    """How many tasks a worker has carried out."""
    return len(dask_worker.state.log)


@settings(max_examples=4)
@given(st.integers(17, 90), st.integers(17, 90), st.sampled_from([0, 5]))
def test_blocks_of_a_dask_array_are_windows(rows: int, columns: int, feather: int) -> None:
    """Any chunks, the same pixels; nothing is drawn before it is asked for."""
    needs("dask")
    texture = small(feather)
    array = texture.to_dask((100, 90), (rows, columns), (-30, -2**31 - 40))
    assert array.shape == (100, 90, 3)
    assert array.dtype == np.uint8
    whole = texture[-30:70, -(2**31) - 40 : -(2**31) + 50]
    assert (array.compute(scheduler="threads") == whole).all()
    assert (array[7:20, 80:].compute(scheduler="sync") == whole[7:20, 80:]).all()


@pytest.mark.parametrize("given", ["fibres", 7, "Local", [1]])
def test_what_is_no_cluster_is_refused(given: Any) -> None:
    with pytest.raises(ParameterError, match="is unknown; give local, the tcp:// address of a dask scheduler, or"):
        check_dask(given)


def test_a_scheduler_that_is_not_there(tmp_path: Path) -> None:
    """It is looked for before anything is written."""
    needs("distributed")
    with pytest.raises(InputError, match="no dask scheduler answers at tcp://"):
        small().to_tiff(tmp_path / "o.tif", 64, dask="tcp://127.0.0.1:9")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("module", ["zarr", "tifffile", "dask", "distributed"])
def test_a_missing_extra_names_what_installs_it(module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exit code 5, before any work."""
    monkeypatch.setitem(sys.modules, module, None)
    asked: dict[str, Callable[[], object]] = {
        "zarr": lambda: small().to_zarr(tmp_path / "o.zarr", 64),
        "tifffile": lambda: small().to_tiff(tmp_path / "o.tif", 64),
        "dask": lambda: small().to_dask(64),
        "distributed": lambda: small().to_tiff(tmp_path / "o.tif", 64, dask="local"),
    }
    with pytest.raises(MissingExtraError) as caught:
        asked[module]()
    assert str(caught.value) == f"{module} is not installed; run: pip install 'intarsia[giant]'"
    assert caught.value.exit_code == 5
    assert not list(tmp_path.iterdir())
