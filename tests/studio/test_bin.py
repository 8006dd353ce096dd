"""What was taken away comes back whole, or goes whole: at the end, or at the next start."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from starlette.exceptions import HTTPException
from studio.served import QUICK, Served, pixels, png, studio

from intarsia.studio.store import Bin, Events, Store

RESULT, OTHER, EXEMPLAR = "a" * 16, "b" * 16, "e" * 16


def filled(folder: Path) -> Store:
    """A folder with two jobs that made the same, and one that made another thing."""
    store = Store(folder)
    for kind, name in (("exemplars", EXEMPLAR), ("results", RESULT), ("results", OTHER)):
        files = store.begun(kind)
        (files / "a.png").write_bytes(name.encode())
        store.keep(kind, files, {"id": name, "job": "1", "made": 1.0})
    for name, made in (("1", RESULT), ("2", RESULT), ("3", OTHER)):
        store.put("jobs", {"id": name, "state": "done", "result": made, "exemplars": [EXEMPLAR], "ended": 1.0})
    return store


def there(store: Store) -> tuple[str, str]:
    """The jobs that are listed, and the first letters of what lies in the folders."""
    names = [path.name[0] for kind in ("exemplars", "results") for path in (store.folder / kind).iterdir()]
    return "".join(job["id"] for job in store.all("jobs")), "".join(sorted(names))


def taken(store: Store, *names: str) -> Bin:
    held = Bin(store, Events())
    for name in names:
        kind = "exemplars" if name == EXEMPLAR else "jobs"
        row = store.get(kind, name)
        assert row is not None
        held.take(kind, row["id"])
    return held


def test_it_comes_back_whole_or_goes_for_ever(tmp_path: Path) -> None:
    store = filled(tmp_path)
    held = taken(store, "3", EXEMPLAR)
    assert there(store) == ("12", "abe")
    assert store.all("exemplars") == []
    held.back("jobs", "3")
    held.back("exemplars", EXEMPLAR)
    held.empty()
    assert there(store) == ("123", "abe")
    with pytest.raises(HTTPException, match="taken away"):
        held.back("jobs", "3")
    taken(store, "3").empty()
    assert there(store) == ("12", "ae")
    with pytest.raises(HTTPException):
        held.back("jobs", "3")
    store.close()


def test_what_two_jobs_made_alike_stays_until_both_are_gone(tmp_path: Path) -> None:
    store = filled(tmp_path)
    taken(store, "1").empty()
    assert there(store) == ("23", "abe")
    taken(store, "2").empty()
    assert there(store) == ("3", "be")
    store.close()


def test_what_a_job_needs_that_is_under_way_cannot_be_taken_away(tmp_path: Path) -> None:
    store = filled(tmp_path)
    store.put("jobs", {"id": "4", "state": "queued", "result": None, "exemplars": [EXEMPLAR]})
    for name in ("4", EXEMPLAR):
        with pytest.raises(HTTPException, match="cancel it first"):
            taken(store, name)
    store.close()


@pytest.mark.parametrize("moment", ["marked", "files gone"])
def test_a_studio_that_is_killed_leaves_nothing_half(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str
) -> None:
    store = filled(tmp_path)
    held = taken(store, "3", EXEMPLAR)
    if moment == "files gone":
        monkeypatch.setattr(store, "drop_row", _killed)
        with pytest.raises(KeyboardInterrupt):
            held.empty()
    store.close()
    store = Store(tmp_path)
    assert there(store)[0] == "12"
    assert store.all("exemplars") == []
    Bin(store, Events()).empty()
    assert there(store) == ("12", "a")
    assert store.all("exemplars", gone=True) == []
    assert store.all("jobs", gone=True) == []
    store.close()


def _killed(*given: Any) -> None:
    raise KeyboardInterrupt


def test_a_studio_forgets_at_its_end_and_takes_again_what_is_opened_anew(tmp_path: Path) -> None:
    with studio(tmp_path) as served:
        one, two = (served.exemplar(**{name: png(pixels(seed=n))})["id"] for n, name in enumerate(("one", "two")))
        result = served.done("grow", [one], **QUICK)
        for path in (f"exemplars/{one}", f"exemplars/{two}", f"jobs/{result['job']}"):
            assert served.client.delete(f"/api/{path}").status_code == 204
            assert served.client.get(f"/api/{path}").status_code == 404
        assert served.post(f"/api/jobs/{result['job']}/back")["result"] == result["id"]
        assert served.files(result)
        assert served.client.delete(f"/api/jobs/{result['job']}").status_code == 204
        assert served.exemplar(two=png(pixels(seed=1)))["id"] == two
        served.post(f"/api/exemplars/{'0' * 16}/back", status=404)
    assert [path.name for path in (tmp_path / "exemplars").iterdir()] == [two]
    assert not list((tmp_path / "results").iterdir())
    again = Served(tmp_path)
    assert again.get("/api/jobs") == []
    assert [row["id"] for row in again.get("/api/exemplars")] == [two]
    again.close()
