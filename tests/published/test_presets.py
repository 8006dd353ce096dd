"""What `grow --as DOCUMENT` sets: all of it options of grow; what is given besides wins."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import intarsia as ia
from intarsia.cli import cli
from intarsia.foundation.params import parameters, parse
from intarsia.methods import PRESETS, method_class, preset
from intarsia.testing import texture


def planned(*words: str) -> dict:
    done = CliRunner().invoke(cli, ["grow", "a.png", "--dry-run", "--json", *words], prog_name="intarsia")
    assert done.exit_code == 0, done.output
    return dict(json.loads(done.stdout))


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tiles = np.tile(texture(12, 12, 3, 4), (6, 6, 1))
    ia.write("a.png", tiles + texture(72, 72, 3, 5) // 16)


@pytest.mark.parametrize("document", PRESETS)
def test_all_that_a_document_sets_is_set(document: str) -> None:
    settings, made = preset(document), planned("--as", document)
    mixing, method = settings.pop("mixing", None), settings.pop("method")
    assert made["method"] == method
    known = {p.name: p for p in parameters(method_class(method))}
    for name, text in settings.items():
        value = parse(known[name], text)
        assert made["parameters"][name] == (list(value) if isinstance(value, tuple) else value), name
    assert mixing is None or made["blend"]["mixing"] == mixing


def test_what_is_given_besides_wins_and_another_method_is_refused() -> None:
    made = planned("--as", "multrus2003", "--patch", "12", "--overlap", "4", "--mixing", "mean")
    assert (made["parameters"]["patch"], made["parameters"]["overlap"]) == (12, 4)
    assert made["blend"]["mixing"] == "mean"
    assert made["parameters"]["search"] == "exact"
    asked = ["grow", "a.png", "--as", "segments", "-m", "repeat"]
    assert "--as segments sets --method segment-based" in CliRunner().invoke(cli, asked).output


def test_one_weight_is_that_of_all_channels() -> None:
    """So that a preset suits gray and coloured exemplars."""
    grown = [
        ia.synthesize("a.png", 90, ia.ImageQuilting(patch=16, channel_weights=w), seed=1).map.digest
        for w in ((1.0,), (1.0, 1.0, 1.0))
    ]
    assert grown[0] == grown[1]
