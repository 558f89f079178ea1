"""The registry of planner options: what is generated from it, and what it says of itself."""

import dataclasses
import importlib.util
from pathlib import Path

import pytest

import srmp
import srmp.options

REPOSITORY = Path(__file__).parents[2]
IDS = list(srmp.available_planners())


def generator():
    path = REPOSITORY / "docs" / "generate_options.py"
    spec = importlib.util.spec_from_file_location("generate_options", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


GENERATED = list(generator().GENERATED.items())


@pytest.mark.parametrize(("path", "generate"), GENERATED, ids=[path.name for path, _ in GENERATED])
def test_generated_files_are_up_to_date(path, generate):
    text = path.read_text(encoding="utf-8")
    assert generate(text) == text, "run python docs/generate_options.py"


def test_stale_tables_and_comments_are_seen():
    module = generator()
    page = module.PAGE.read_text(encoding="utf-8").replace("| `time_limit` | 5.0 |", "| `time_limit` | 6.0 |")
    assert module.page_text(page) != page
    with pytest.raises(ValueError, match="no markers for 'planners of one robot'"):
        module.page_text("# Planners")
    header = module.HEADER.read_text(encoding="utf-8")
    with pytest.raises(ValueError, match="0 fields 'weight'"):
        module.header_text(header.replace("double weight{50.0};", "double heft{50.0};"))
    with pytest.raises(ValueError, match="no struct 'WAStar'"):
        module.header_text(header.replace("struct WAStar {", "struct Pohl {"))


def test_the_package_has_a_class_for_each_planner():
    assert [srmp.planner_info(id_).id for id_ in IDS] == IDS
    assert sorted(srmp.options.__all__) == sorted(srmp.planner_info(id_).class_name for id_ in IDS)
    assert set(srmp.options.__all__) <= set(dir(srmp))


@pytest.mark.parametrize("planner_id", IDS)
def test_typed_options_are_those_of_the_registry(planner_id):
    planner = srmp.planner_info(planner_id)
    options = getattr(srmp, planner.class_name)()
    assert options.to_dict() == srmp.planner_options({"planner_id": planner_id})
    assert options.to_dict() == {"planner_id": planner_id, **{o.name: o.default for o in planner.options}}
    fields = {field.name: field.type for field in dataclasses.fields(options)}
    assert ("robots" in fields) == any(option.per_robot for option in planner.options)
    assert planner.many_robots or "robots" not in fields
    assert {option.name: option.type for option in planner.options}.items() <= fields.items()


@pytest.mark.parametrize("planner_id", IDS)
def test_values_at_the_ends_of_a_range(planner_id):
    """What a range says is what is accepted."""
    for option in srmp.planner_info(planner_id).options:
        for bound in filter(None, option.range.split(" and ")):
            relation, limit = bound.split()
            given = {"planner_id": planner_id, option.name: float(limit)}
            if relation == ">":
                with pytest.raises(srmp.InvalidArgument, match=f"'{option.name}' is {limit}; it must be above {limit}"):
                    srmp.planner_options(given)
            else:
                assert srmp.planner_options(given)[option.name] == float(limit)
                past = float(limit) + (1 if relation == "<=" else -1)
                with pytest.raises(srmp.InvalidArgument, match=f"'{option.name}' is"):
                    srmp.planner_options(given | {option.name: past})
        for choice in option.choices:
            assert srmp.planner_options({"planner_id": planner_id, option.name: choice})[option.name] == choice


def test_an_options_facts():
    options = {option.name: option for option in srmp.planner_info("auto").options}
    limit = options["time_limit"]
    assert (limit.type, limit.default, limit.unit, limit.range, limit.common) == ("float", 5.0, "s", "> 0", True)
    rounds = options["improve_rounds"]
    assert (rounds.type, rounds.range, rounds.common) == ("int", ">= 0", False)
    assert type(rounds.default) is int
    assert options["direction"].choices == ["auto", "forward", "backward"]
    assert options["heuristic"].per_robot and not options["resolution"].per_robot
    assert repr(limit) == "<OptionInfo 'time_limit'>"


def test_planners_by_other_spellings():
    assert srmp.planner_info("wA*").id == "wAstar"
    with pytest.raises(srmp.InvalidArgument, match="no planner 'wAstr', did you mean 'wAstar'"):
        srmp.planner_info("wAstr")
