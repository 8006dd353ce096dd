"""Help fits a screen; what it leaves out stands in --help-all."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from intarsia.cli import COMMANDS, cli
from intarsia.cli.verbs import MOST_USED, HelpfulCommand, ParameterOption, parameters_of
from intarsia.files import read_recipe
from intarsia.foundation.params import parameters
from intarsia.methods import METHODS, method_class, method_of
from intarsia.request import FIELDS, HEADINGS, from_json

GROWING = ("grow", "extend", "heal", "paint", "tile", "weave")


def found(name: str) -> click.Command:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    command.params = command.params or parameters_of(name)
    return command


SHORT = [name for name in COMMANDS if isinstance(found(name), HelpfulCommand)]


def told(*words: str, code: int = 0) -> str:
    result = CliRunner().invoke(cli, list(words), env={"COLUMNS": "80"})
    assert result.exit_code == code, result.output
    return result.stdout if code == 0 else result.stderr


def options(name: str) -> list[click.Option]:
    return [p for p in found(name).params if isinstance(p, click.Option) and not p.hidden]


def first(option: click.Option) -> str:
    """The long name by which an option is listed."""
    return next(name for name in option.opts if name.startswith("--"))


def shown(text: str) -> list[str]:
    """The long options that a help lists, in its order."""
    return re.findall(r"^  (?:-\w, )?(--[\w-]+)", listed(text), re.MULTILINE)


def listed(text: str) -> str:
    """A help from its first heading on."""
    return re.split(r"(?m)^\w.*:$", text, maxsplit=1)[-1]


def slugs(name: str) -> list[str]:
    kind = next(p.type for p in found(name).params if p.name == "method")
    assert isinstance(kind, click.Choice)
    return [slug for slug in METHODS if slug in kind.choices]


def test_all_that_work_on_exemplars_have_a_short_help() -> None:
    assert set(SHORT) == set(COMMANDS) - {"methods", "warm-up", "studio", "install-plugin", "where"}


@pytest.mark.parametrize("name", SHORT)
class TestShort:
    def test_fits_a_screen(self, name: str) -> None:
        lines = told(name, "--help").splitlines()
        assert len(lines) <= 46
        examples = [line for line in lines if line.startswith(f"  intarsia {name}")]
        assert all(len(line) <= 80 for line in lines if line not in examples)
        assert len(shown(told(name, "--help"))) <= 23

    def test_has_groups_and_says_where_the_rest_is(self, name: str) -> None:
        text = told(name, "--help")
        headings = re.findall(r"^(\w[\w ]*):\n  ", text, re.MULTILINE)
        assert headings == [h for h in HEADINGS if h in headings]
        assert {"Exemplar", "Work"} | ({"Output"} if name != "analyze" else set()) <= set(headings)
        last = text[-200:].replace("\n", " ")
        assert f"`intarsia {name} --help-all`" in last
        assert ("`intarsia methods METHOD`" in last) is (name in GROWING)

    def test_every_option_stands_in_one_group(self, name: str) -> None:
        own = {str(o.name) for o in options(name) if not isinstance(o, ParameterOption)}
        assert own == {f.name for f in FIELDS if name in f.verbs and f.of(name).flags}
        usual = [f.name for f in FIELDS if not f.rare or (name in f.verbs and f.of(name).required)]
        expected = {f for f in usual if f in own} | {f for f in MOST_USED if f in {o.name for o in options(name)}}
        by_name = {first(o): str(o.name) for o in options(name)}
        assert {by_name[word] for word in shown(told(name, "--help"))} == expected

    def test_all_options_are_in_help_all(self, name: str) -> None:
        text = told(name, "--help-all")
        assert sorted(shown(text)) == sorted([*map(first, options(name)), "--help", "--help-all"])
        flat = re.sub(r"\s+", "", text)
        assert all(re.sub(r"\s+", "", o.help or "") in flat for o in options(name))

    def test_what_is_short_is_a_sentence(self, name: str) -> None:
        for line in listed(told(name, "--help")).splitlines():
            if re.match(r"  -\S", line):
                assert re.fullmatch(r".*  [A-Z].*[^.]\.", line), line

    def test_a_wrong_option_is_told_with_the_right_one(self, name: str) -> None:
        said = told(name, "--help-oll", code=2)
        assert "--help-all" in said
        assert f"(see intarsia {name} --help)" in said


@pytest.mark.parametrize("name", GROWING)
def test_help_may_stand_beside_a_method(name: str) -> None:
    """It is that of the command; what belongs to a method alone is listed in full help, and by `methods`."""
    assert shown(told(name, "-m", "auto", "--help")) == shown(told(name, "--help"))
    for slug in slugs(name):
        kept = {"--" + p.name.replace("_", "-") for p in parameters(method_class(slug)) if p.name in MOST_USED}
        others = set(shown(told(name, "--help"))) - {f"--{word}" for word in MOST_USED}
        assert set(shown(told(name, "-m", slug, "--help"))) == others | kept


@pytest.mark.parametrize(("words", "right"), [
    ("--fether", "--feather"), ("--refinement", "--refinements"), ("--toroid", "--toroidal"), ("--sheed", "--seed"),
])  # fmt: skip
def test_suggestions_know_what_the_short_help_leaves_out(words: str, right: str) -> None:
    said = told("grow", "a.png", words, code=2)
    assert said.count("\n") == 1
    assert right in said


@pytest.mark.parametrize("word", ["--tileable", "--seamless"])
def test_what_others_call_it_leads_to_wrap(word: str) -> None:
    for command in ("grow", "extend", "heal"):
        assert "Did you mean '--wrap both'? (see " in told(command, "a.png", word, code=2)
    assert "--wrap" not in told("tile", "a.png", word, code=2)


def test_wrap_without_a_value_means_both() -> None:
    for words in ("--wrap -o o.png --json", "-o o.png --json --wrap"):
        answer = told("grow", "sample:stones", "--dry-run", "--quiet", "--size", "200", *words.split())
        assert '"wrap": "both"' in answer


def test_options_of_version_01_are_accepted_with_their_names_of_now(tmp_path: Path) -> None:
    out = str(tmp_path / "o.png")
    said = CliRunner().invoke(
        cli, ["grow", "sample:stones", "-m", "graphcut", "--size", "64", "-o", out, "--usage", "0.1", "--structure=0.5"]
    )
    assert said.exit_code == 0, said.output
    assert "--usage is called --repeat-penalty now." in said.stderr.splitlines()
    recipe = read_recipe(out)["parameters"]
    assert (recipe["repeat_penalty"], recipe["edge_weight"]) == (0.1, 0.5)


def test_recipes_and_jobs_of_version_01_are_read() -> None:
    assert method_of("graphcut", {"usage": 0.1}) == method_of("graphcut", {"repeat_penalty": 0.1})
    assert from_json("grow", {"method": "graphcut", "level": 4}, files=("a.png",)).even_tone == 4
