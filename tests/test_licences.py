"""No package that is installed with intarsia is under GPL, LGPL or AGPL."""

from __future__ import annotations

import re
from importlib.metadata import Distribution, PackageNotFoundError, distribution

from packaging.requirements import Requirement

COPYLEFT = re.compile(r"\b[AL]?GPL|GNU (?:Affero |Lesser |Library )?General Public", re.IGNORECASE)
# The licence file of a wheel may also hold those of compiler run-times inside it, which are exempt; so only what the
# package says of itself counts.


def needed(name: str, found: dict[str, Distribution]) -> dict[str, Distribution]:
    """Collect a distribution and all that it requires here, without extras."""
    key = re.sub(r"[-_.]+", "-", name).lower()
    if key in found:
        return found
    try:
        found[key] = distribution(name)
    except PackageNotFoundError as e:
        raise AssertionError(f"{name} is required, but not installed") from e
    for line in found[key].requires or []:
        requirement = Requirement(line)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            needed(requirement.name, found)
    return found


def stated(one: Distribution) -> list[str]:
    """Return what a distribution says of its licence: expression, classifiers, and a short licence field."""
    about = one.metadata
    said = about.get_all("License-Expression") or []
    said += [c for c in about.get_all("Classifier") or [] if c.startswith("License ::")]
    if not said:
        said = [line for text in about.get_all("License") or [] for line in text.splitlines()[:3]]
    return said


def alternatives(text: str) -> list[str]:
    """Split a choice of licences; one acceptable choice is enough."""
    return re.split(r"\s+OR\s+", text)


def refused(one: Distribution) -> list[str]:
    return [s for s in stated(one) if all(COPYLEFT.search(a) and "exception" not in a.lower() for a in alternatives(s))]


def test_no_requirement_is_under_the_gpl() -> None:
    found = needed("intarsia", {})
    assert {"numpy", "numba", "openimageio", "click"} <= set(found)
    assert {name: refused(one) for name, one in found.items() if refused(one)} == {}


def test_every_requirement_states_a_licence() -> None:
    silent = [name for name, one in needed("intarsia", {}).items() if not stated(one)]
    assert [n for n in silent if not list(distribution(n).metadata.get_all("License-File") or [])] == []


def test_the_check_finds_what_it_looks_for() -> None:
    for text in ("GPL-3.0-or-later", "LGPLv2+", "AGPL-3.0", "License :: GNU General Public License v3 (GPLv3)"):
        assert COPYLEFT.search(text)
    for text in ("MIT", "BSD-3-Clause", "Apache-2.0", "MIT-CMU"):
        assert not COPYLEFT.search(text)
