"""A field of a request, and how one is declared: once, and help, page, recipe and snippets read it there."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from .kinds import FLAG, Kind

HEADINGS = ("What goes where", "Output", "Look", "Exemplar", "Work")
"""What the options of a verb stand under in its help, in this order."""

WHERE, OUTPUT, LOOK, EXEMPLAR, WORK = HEADINGS


@dataclass(frozen=True)
class Field:
    """What is known of a field: option of some verbs, key of a job, and place in a recipe, if that holds it.

    Without ``flags`` it is an argument. ``heading`` says where help lists it, if ``rare`` only in full help; ``shown``
    what help shows in place of a value; ``local`` what the studio gives itself, or does not need; ``passing`` what
    bears on nothing that is in the picture. ``alone`` is the value of an option that is given none. ``otherwise`` holds
    what is another with some verbs.
    """

    name: str
    kind: Kind
    flags: tuple[str, ...]
    help: str
    heading: str
    verbs: Collection[str]
    default: Any = None
    shown: str = ""
    many: bool = False
    required: bool = False
    rare: bool = False
    recipe: str = ""
    local: bool = False
    passing: bool = False
    alone: str | None = None
    tells_default: bool = False
    otherwise: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def flag(self) -> str:
        """The longest name of the option."""
        return max(self.flags, key=len)

    @property
    def key(self) -> str:
        """What the field is called in a job."""
        return self.flag.lstrip("-").replace("-", "_")

    @property
    def of_exemplars(self) -> bool:
        """Whether it says what of the exemplars is used, and how."""
        return self.recipe.startswith("inputs.")

    def of_json(self, value: Any) -> Any:
        """Read the field as a recipe holds it; an exception says that it is damaged."""
        if self.many:
            return tuple(self.kind.read(f"{name}={one}") for name, one in value.items())
        return self.kind.of_json(value)

    def of(self, verb: str) -> Field:
        """The field as a verb has it."""
        return replace(self, **self.otherwise.get(verb, {}))


def asked(
    kind: Kind, flags: str, help: str, verbs: Collection[str], marks: str = "", default: Any = None, **facts: Any
) -> Any:  # fmt: skip
    """Declare a field of the request; `flags` are the names of its option, `facts` those of :class:`Field`.

    `marks` name what of :class:`Field` is true. A heading holds for the fields below, too, until the next.
    """
    facts |= dict.fromkeys(marks.split(), True)
    if default is None:
        default = () if "many" in facts else False if kind is FLAG else None
    facts |= {"kind": kind, "flags": tuple(flags.split()), "help": help, "verbs": verbs, "default": default}
    return dataclasses.field(default=default, metadata={"asked": facts})


def fields_of(request: Any) -> tuple[Field, ...]:
    """List what may be asked for, in the order of a request's fields."""
    found, heading = list[Field](), ""
    for f in dataclasses.fields(request):
        if "asked" in f.metadata:
            facts = {"heading": heading, **f.metadata["asked"]}
            heading = facts["heading"]
            found.append(Field(f.name, **facts))
    return tuple(found)
