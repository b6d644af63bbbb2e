"""The page on commands: every column and every key that commands write is described in the section of the command."""

import csv
import json
import re
from contextlib import chdir
from types import SimpleNamespace

import option_tables
import pytest
import yaml
from bundled import MODELS, ROOT
from fences import MANUAL
from in_process import gim
from typer.main import get_command

from gimcli import load
from gimcli.branching import singularities
from gimcli.cli import COMMANDS, app
from gimcli.comparison.methods import METHODS
from gimcli.dynamics import simulation_types
from gimcli.dynamics.integrators import INTEGRATORS
from gimcli.manual.pages import manual_text
from gimcli.model.source import read_source
from gimcli.quantities.kinds import KINDS
from gimcli.status import CHANGE, TANGENCY, Status

TEXT = (MANUAL / "commands.md").read_text(encoding="utf-8")
NAMES = {
    "ACTUATOR": lambda m: [a.name for a in m.actuators],
    "NODE": lambda m: [*m.nodes, *(p.name for p in m.points)],
    "POINT": lambda m: m.traced,
    "MEMBER": lambda m: [*(member.name for member in m.members), *(slide.pair for slide in m.slides)],
    "PAIR": lambda m: [slide.pair for slide in m.slides],
}
"""Words of the page in capitals, and the names of a model that each stands for."""
FREE = {
    "SPEC": r"(?:centre|curvature|transmission|advantage|area):[^.]*",
    "COLUMN": r"(?:centre|curvature|transmission|advantage|area):.*",
    "REACTION": r".+",
    "FORCE": r".+",
    "LENGTH": r"[^.]+",
    "DIMENSION": r"[\w.]+",
    "QUANTITY": r".+\(.+\)|type|solved",
    "STATUS": r"[a-z-]+",
    "VALUE": r"\w+\.(?:x|y|angle)",
    "SPREAD": r"worst|rss|sd|mean_shift|mean_shift_error|sampled_sd|sampled_sd_error|least|greatest",
}


def changed(name, **sections):
    """Return a change of a bundled model: sections that replace its own."""
    return {**read_source(MODELS / f"{name}.yaml").data, **sections}


def massive(name, **more):
    """Return a bundled model in metres whose members have masses."""
    members = load(MODELS / f"{name}.yaml").members[1:]
    masses = {m.name: {"mass": 1.0, "inertia": 0.1} for m in members}
    return changed(name, units={"length": "m"}, masses=masses, gravity=[0, -9.81], **more)


def moved(name, **law):
    """Return the actuators of a bundled model with another law."""
    return {key: {**value, "law": law} for key, value in changed(name)["actuators"].items()}


def freed(name, actuator):
    """Return the actuators of a bundled model, one of them free, the others at rest."""
    return {k: {**a, "free": k == actuator} for k, a in moved(name, by=0).items()}


TOLERANCES = {"crank": 0.05, "P.x": 0.02}
MEASURES = ["-m", "transmission", "-m", "centre:coupler/rocker", "-m", "centre:frame/coupler", "-m", "curvature:P",
            "-m", "advantage:motor/rocker", "-m", "area:coupler"]  # fmt: skip
TARGETS = str(ROOT / "examples" / "arc.csv")
CASES = {
    "solve": ("crank_rocker", ["solve"]),
    "solve, velocities": ("crank_rocker", ["solve", "--velocities", "--at", "motor=40"]),
    "solve, history": ("gim_fig11", ["solve", "--method", "gim", "--history", "--at", "FD=100", "--tolerance", "1e-5"]),
    "solve, failed": ("chebyshev", ["solve", "--at", "motor=179"]),
    "solve, all": ("double_butterfly", ["solve", "--all"]),
    "trace": ("crank_rocker", ["trace", "-n", "12", "-d", "3", *MEASURES]),
    "trace, limit": (changed("chebyshev", actuators=moved("chebyshev", by=120)), ["trace", "-n", "12"]),
    "trace, circuit": ("chebyshev", ["trace", "-n", "12", "--circuit", "-m", "transmission"]),
    "trace, all branches": ("parallelogram", ["trace", "-n", "12", "--all-branches", "-m", "transmission"]),
    "check": ("slider_crank", ["check"]),
    "check, loops": (massive("jansen", duration=2), ["check"]),
    "check, coupled": ("innocenti_group", ["check"]),
    "fit": ("crank_rocker", ["fit", "--vary", "crank.length=30:45", "--through", TARGETS, "--starts", "20"]),
    "fit, goal": ("crank_rocker", ["fit", "--vary", "crank.length=30:45", "--goal", "max(P.y)", "--starts", "20"]),
    "workspace": ("five_bar", ["workspace", "--grid", "6"]),
    "workspace, ranges": (changed("five_bar", actuators=moved("five_bar", by=60)), ["workspace"]),
    "workspace, paths": ("chebyshev", ["workspace"]),
    "mobility": ("parallelogram_third_crank", ["mobility"]),
    "groups": ("stephenson_3_far", ["groups"]),
    "groups, sliding": ("crank_shaper", ["groups"]),
    "sequence": ("double_butterfly", ["sequence"]),
    "singularities": ("parallelogram", ["singularities"]),
    "singularities, limits": ("chebyshev", ["singularities"]),
    "circuits": ("crank_rocker", ["circuits", "--samples", "8"]),
    "equilibrium": ("snap_hinge", ["equilibrium"]),
    "equilibrium, several": ("balanced_lamp", ["equilibrium", "--set", "lamp=0.7", "--starts", "3"]),
    "forces": ("watt_1", ["forces", "-n", "6"]),
    "forces, sliding": (massive("crank_shaper"), ["forces", "-n", "6"]),
    "forces, redundant": (massive("parallelogram_third_crank"), ["forces", "-n", "6"]),
    "forces, several members": (massive("jansen"), ["forces", "-n", "6"]),
    "forces, dry friction": ("crank_press", ["forces", "-n", "6"]),
    "modes": ("double_pendulum", ["modes"]),
    "modes, damped": ("swing", ["modes", "--settle"]),
    "modes, phases": (
        changed("double_pendulum", dampers={"d": {"pivot": "O", "arm": "A", "damping": 1}}), ["modes"],
    ),
    "modes, not settled": (
        massive("crank_rocker", loads={"t": {"on": "crank", "torque": 1e6}}), ["modes", "--settle"],
    ),
    "simulate": ("watt_durango", ["simulate", "--time", "0.5", "--dt", "0.1", "--reactions"]),
    "simulate, law": (
        massive("five_bar", actuators=freed("five_bar", "motor_1")), ["simulate", "--time", "1", "--dt", "0.5"],
    ),
    "reduce": ("watt_1", ["reduce", "-n", "6", "--rpm", "60", "--fluctuation", "0.1"]),
    "sensitivity": (
        changed("crank_rocker", tolerances=TOLERANCES),
        ["sensitivity", "-n", "4", "--of", "P.x", "--of", "rocker", "--samples", "100"],
    ),
    "sensitivity, position": (
        changed("crank_rocker", tolerances=TOLERANCES),
        ["sensitivity", "--at", "motor=30", "--of", "P", "--samples", "100"],
    ),
    "sweep": ("crank_rocker", ["sweep", "--vary", "crank.length=40,41", "--keep", "max(P.y)", "--keep", "type"]),
    "sweep, best": (
        "crank_rocker", ["sweep", "--vary", "crank.length=40,41", "--goal=max(P.y)", "--best=1", "--keep=solved"],
    ),
    "tradeoff": ("crank_rocker", ["tradeoff", "-n", "4", "--tolerances", "1e-4", "--seconds", "1"]),
}  # fmt: skip


def described(command, kind):
    """Return what stands in the first cells of the tables of a kind in a command's section, and in the common ones."""
    found = []
    for text in (manual_text(command), TEXT[TEXT.index("### JSON") : TEXT.index("### Exit")]):
        for head, rows in re.findall(r"(?m)^\| ([^|\n]+?) \|.*\n\|[-|]+\n((?:\|.*\n)+)", text):
            if kind in head or (kind == "key" and head == "key"):
                for row in rows.splitlines():
                    found += re.findall(r"`([^`]+)`", re.split(r"(?<!\\)\|", row)[1])
    return found


def pattern(words, model):
    """Return a regular expression for a pattern of the page."""
    names = {word: "|".join(map(re.escape, names(model))) or "(?!)" for word, names in NAMES.items()} | FREE
    parts = re.split(rf"\b({'|'.join(names)})\b", words)
    return "".join(f"(?:{names[part]})" if part in names else re.escape(part) for part in parts)


def paths(value, path=()):
    """Yield the path of keys to every leaf of a report, and whether it is empty; a list of numbers is a leaf."""
    if isinstance(value, dict) and value:
        for key, part in value.items():
            yield from paths(part, (*path, key))
    elif isinstance(value, list) and any(isinstance(part, dict | str) for part in value):
        for part in value:
            yield from paths(part, (*path[:-1], f"{path[-1]}[]"))
    else:
        yield ".".join(path), value in ({}, [])


def heads(words):
    """Return a path, and those of all that holds it, without the brackets of a list at their ends."""
    parts = words.split(".")
    return {".".join(parts[:k]).removesuffix("[]") for k in range(1, len(parts) + 1)}


@pytest.fixture(scope="module", params=CASES)
def run(request, tmp_path_factory):
    """Run a command; return its name, its model, the head of its table and its report."""
    model, (command, *options) = CASES[request.param]
    folder = tmp_path_factory.mktemp("page")
    data = changed(model) if isinstance(model, str) else model
    (folder / "model.yaml").write_text(yaml.safe_dump(data, sort_keys=False).replace("true:", "'on':"))
    with chdir(folder):
        done = gim(command, "model.yaml", *options, "-o", "table.csv", "--json")
    assert done.code in (0, 5), done.error
    with (folder / "table.csv").open(newline="", encoding="utf-8") as handle:
        head = next(csv.reader(handle))
    return command, load(folder / "model.yaml"), head, json.loads(done.text)


def test_every_column_is_described(run):
    command, model, head, _ = run
    known = [pattern(words, model) for words in described(command, "column")]
    missing = [name for name in head if not any(re.fullmatch(one, name) for one in known)]
    assert not missing


def test_every_key_is_described(run):
    command, model, _, report = run
    words = described(command, "key")
    if command == "tradeoff":
        words += [f"entries[].{name}" for name in described(command, "column")]
    if "circuits[].measures" in words:
        words += [f"circuits[].{word}" for word in words if word.startswith("measures.")]
    full = [pattern(word.removesuffix("[]"), model) + r"(?:\[\])?" for word in words]
    part = [pattern(head, model) for word in words for head in heads(word)]
    missing = [
        path for path, empty in paths(report) if not any(re.fullmatch(one, path) for one in (part if empty else full))
    ]
    assert not missing


def test_the_tables_of_options_are_those_of_the_commands():
    """`python tests/oracles/option_tables.py` writes them; each section has one, if the command has options."""
    assert option_tables.written(TEXT) == TEXT
    assert [name for name in COMMANDS if option_tables.HEAD not in manual_text(name)] == ["schema"]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_shell_completes_the_options_of_a_command(command):
    """The options, their help and their words are those of the command, which is not imported for it."""
    group, shell = get_command(app), SimpleNamespace(resilient_parsing=True)
    own, read = group.get_command(None, command), group.get_command(shell, command)

    def offered(one):
        return {item.value: item.help for item in one.shell_complete(one.context_class(one), "-")}

    helps = {
        name: option_tables.shown((text or "").partition("\n")[0], own.kind) for name, text in offered(own).items()
    }
    found = {name: (text or "").replace("|", r"\|") for name, text in offered(read).items()}
    assert helps == found
    words = {flag: option_tables.values(p, own) for p in own.params for flag in p.opts}
    for param in (p for p in read.params if p.param_type_name == "option"):
        known = words[param.opts[0]]
        assert option_tables.values(param, read) == (known if known.startswith("`") or known == "repeatable" else "")


def test_the_first_line_of_an_option_is_one_sentence_without_links():
    group = get_command(app)
    lines = [(p.help or "").split("\n")[0] for c in COMMANDS for p in group.get_command(None, c).params]
    assert [line for line in lines if "](" in line or re.search(r"[^.]\. ", line)] == []


def test_all_words_are_on_the_page():
    words = {f"`{status.word}`" for status in Status}
    words |= {f"`{k}`" for k in (singularities.LIMIT, singularities.DEAD, singularities.STATIONARY, CHANGE, TANGENCY)}
    words |= {
        f"`{getattr(simulation_types, k)}`"
        for k in ("STANDSTILL", "DEAD_POINT", "LIMIT", "SINGULAR", "STICKS", "SLIDES", "JAM")
    }
    words |= {f"`{name}`" for name in [*INTEGRATORS, *(method.name for method in METHODS), "sequence exchanged"]}
    assert {word for word in words if word not in TEXT} == set()
    assert all(re.search(rf"(?m)^\| `{kind}\b", TEXT) for kind in KINDS)
