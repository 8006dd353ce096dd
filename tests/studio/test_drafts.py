"""Drafts: at once, coarse, and of the whole that a job will make."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from studio.served import Served, opened, png

from intarsia.studio.pictures import Drafts, Pictures
from intarsia.studio.processes import FailedError, Process
from intarsia.studio.store import Store


def asked(served: Served, exemplar: str, verb: str = "grow", **options: Any) -> Any:
    """What is answered when a draft is asked for, once there are drafts."""
    given = {"verb": verb, "exemplars": [exemplar], "options": options}
    ready = {"verb": "grow", "exemplars": [exemplar], "options": {"size": "64x64"}}
    until = time.monotonic() + 240  # something may have to be compiled
    while served.client.post("/api/drafts", json=ready).status_code == 204 and time.monotonic() < until:
        time.sleep(0.05)
    return served.client.post("/api/drafts", json=given)


@pytest.fixture(scope="module")
def halves(served: Served) -> str:
    """An exemplar whose left half is red, and the right one green."""
    grown = np.random.default_rng(3).integers(0, 40, (128, 128, 3))
    grown[:, :64, 0] += 200
    grown[:, 64:, 1] += 200
    return str(served.exemplar(halves=png(grown.astype(np.uint8)))["id"])


@pytest.mark.parametrize(
    ("size", "drawn"),
    [("48x40", (40, 48)), ("512x256", (256, 512)), ("1600x800", (266, 533)), ("2048x2048", (682, 682))],
)
def test_a_draft_has_the_shape_of_what_is_wanted_and_is_small(
    served: Served, halves: str, size: str, drawn: tuple[int, int]
) -> None:
    answer = asked(served, halves, size=size, seed=2)
    assert (answer.status_code, answer.headers["content-type"]) == (200, "image/png")
    found = opened(answer.content)
    assert found.shape == (*drawn, 3)
    red = found[..., 0] > found[..., 1]
    assert 0.01 < red.mean() < 0.99
    assert asked(served, halves, size=size, seed=2).content == answer.content
    assert asked(served, halves, size=size, seed=3).content != answer.content


@pytest.mark.parametrize("side", [256, 1024])
def test_a_painted_draft_shows_each_texture_where_it_was_painted(served: Served, halves: str, side: int) -> None:
    labels = np.zeros((128, 128), np.uint8)
    labels[:, 64:] = 1
    target = np.zeros((side, side), np.uint8)
    target[side // 4 : 3 * side // 4, side // 4 : 3 * side // 4] = 1
    ids = {"labels": [served.image(labels)], "target": served.image(target)}
    answer = asked(served, halves, "paint", **ids)
    assert answer.status_code == 200
    found = opened(answer.content)
    assert found.shape[0] == found.shape[1] >= 256
    wanted = target[:: side // found.shape[0], :: side // found.shape[0]] == 1
    green = found[..., 1] > found[..., 0]
    assert (green == wanted).mean() > 0.9


def test_what_has_no_draft_is_no_error(served: Served, small: str) -> None:
    for answer in (
        asked(served, small, "tile"),
        asked(served, small, size="4000x4000"),  # so small an exemplar cannot be reduced
    ):
        assert (answer.status_code, answer.content) == (204, b"")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"verb": "fly"}, "fly is no verb"),
        ({"verb": "grow", "options": {"size": "large"}}, "size: large is no size"),
        ({"verb": "grow", "exemplars": "all"}, "a job has a verb, exemplars"),
        ({"verb": "grow", "seed": 1}, "a job has a verb, exemplars"),
        ({"verb": "grow", "exemplars": ["0" * 16]}, "is not the id of an exemplar"),
        ({"verb": "paint", "options": {"target": "0" * 16}}, "is not the id of an image"),
    ],
)
def test_what_is_malformed_is_refused_as_a_job_is(served: Served, small: str, given: Any, said: str) -> None:
    given = {"exemplars": [small]} | given
    told = served.post("/api/drafts", given, 400)["error"]
    assert said in told
    assert "\n" not in told
    assert served.post("/api/jobs", given, 400)["error"] == told
    assert served.client.post("/api/drafts", content=b"[]").status_code == 400


def test_a_finer_draft_of_a_painting_is_grown_at_full_size(served: Served, halves: str) -> None:
    labels = np.zeros((128, 128), np.uint8)
    labels[:, 64:] = 1
    options = {"labels": [served.image(labels)], "target": served.image(labels)}
    job = {"verb": "paint", "exemplars": [halves], "options": options}
    coarse = asked(served, halves, "paint", **options)
    fine = served.client.post("/api/drafts?fine", json=job)
    assert [coarse.status_code, fine.status_code] == [200, 200]
    assert opened(fine.content).shape == opened(coarse.content).shape == (128, 128, 3)
    assert fine.content != coarse.content


class Lazy:
    """A process that asks whether the client is still there, as a process does when its turn comes."""

    def __init__(self) -> None:
        self.made = 0

    async def ask(self, do: str, gone: Any = None, **given: Any) -> Any:
        if gone is not None and await gone():
            raise FailedError("nobody waits for this any more.")
        self.made += 1
        return {}, b"a draft"


def test_for_a_client_that_has_gone_nothing_is_drawn(tmp_path: Path) -> None:
    async def gone() -> bool:
        return True

    async def work() -> None:
        store, process = Store(tmp_path), Lazy()
        store.put("exemplars", {"id": "0" * 16, "name": "a", "width": 9, "height": 9, "files": ["a.png"]})
        drafts = Drafts(store, Pictures(), Process())
        drafts.process = cast(Any, process)
        job = {"verb": "grow", "exemplars": ["0" * 16], "options": {}}
        assert await drafts.get(job, gone) == b""
        assert [await drafts.get(job), await drafts.get(job)] == [b"a draft"] * 2
        assert process.made == 1  # it is kept
        store.close()

    asyncio.run(work())
