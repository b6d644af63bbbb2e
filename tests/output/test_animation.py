"""The data of animated pages: positions, columns and events are those of the results, and all texts are inert."""

import base64
import hashlib
import json
import math
import re
import subprocess
import sys

import numpy as np
import pytest
import yaml
from bundled import MODELS
from in_process import gim

import gimcli
from gimcli.output.animation import MOST_ROWS, shown_rows
from gimcli.output.page import page, page_json
from gimcli.output.page.data import page_data, rounded
from gimcli.rounding import Section


def model(name, **actuator):
    """Return a bundled mechanism; `actuator` changes its first actuator."""
    mechanism = gimcli.load(MODELS / f"{name}.yaml")
    if not actuator:
        return mechanism
    from gimcli.model.source import read_source

    data = read_source(MODELS / f"{name}.yaml").data
    first = next(iter(data["actuators"]))
    data["actuators"][first] |= actuator
    return gimcli.load(data)


def floats(text):
    return np.frombuffer(base64.b64decode(text), "<f4").astype(float)


def places(data, clip=0):
    """Return the positions (rows, nodes) of the page in coordinates of the file."""
    pairs = floats(data["clips"][clip]["positions"]).reshape(-1, len(data["scene"]["nodes"]), 2)
    return pairs[..., 0] + 1j * pairs[..., 1] + complex(*data["origin"])


def columns(data, clip=0):
    return {column["name"]: floats(column["values"]) for column in data["clips"][clip]["columns"]}


def words(data, clip=0):
    return [word for word, count in data["clips"][clip]["status"] for _ in range(count)]


@pytest.mark.parametrize("name", ["crank_rocker", "excavator", "scotch_yoke", "floating_hexagon"])
def test_positions_are_those_of_the_result(name):
    found = gimcli.trace(model(name), 36)
    data = page_data(found.animation())
    size = max(data["box"]) - min(data["box"])
    z = places(data)
    for k, node in enumerate(found.mechanism.nodes):
        x, y = found.xy[node].T
        assert np.max(np.abs(z[:, k] - (x + 1j * y))) < 1e-6 * size
    assert words(data) == list(found.status)


def test_far_from_the_origin_positions_are_as_accurate():
    text = (MODELS / "crank_rocker.yaml").read_text()
    data = yaml.safe_load(text)
    for part in (data["nodes"], data["points"]):
        for name, value in part.items():
            at = value if isinstance(value, list) else value.get("at")
            if at is not None:
                moved = [at[0] + 1e6, at[1] - 1e6]
                part[name] = moved if isinstance(value, list) else value | {"at": moved}
    found = gimcli.trace(gimcli.load(data), 12)
    x, y = found.xy["B"].T
    assert np.max(np.abs(places(page_data(found.animation()))[:, 3] - (x + 1j * y))) < 1e-4


def test_columns_have_the_six_digits_of_the_table():
    found = gimcli.trace(model("crank_rocker"), 360, derivatives=2, measure="transmission")
    shown = columns(page_data(found.animation()))
    for column in found.table().columns:
        if column.name in ("status", "residual"):
            continue
        size = np.max(np.abs(column.values))
        for value, own in zip(column.values.tolist(), shown[column.name].tolist(), strict=True):
            assert f"{own:.6g}" == f"{value if abs(value) > 1e-12 * size else 0.0:.6g}"


def test_rounding_keeps_gaps_and_extremes():
    values = np.array([math.nan, math.inf, -math.inf, 0.0, 1e-300, 1234567.0, -9.999999e-9, 3e37, 1.0])
    wanted = [math.nan, math.inf, -math.inf, 0.0, 0.0, 0.0, 0.0, 3e37, 0.0]
    np.testing.assert_allclose(rounded(values), wanted, rtol=1e-15, atol=0.0)
    assert rounded(np.array([1234567.0, 0.00123456789])).tolist() == [1234570.0, 0.00123457]


def test_velocities_of_nodes():
    """A crank of length 40 that turns once in a second: v = 2 pi r, a = (2 pi)^2 r."""
    clip = gimcli.trace(model("crank_rocker"), 36).animation().clips[0]
    node = ["O2", "O4", "A", "B"].index("A")
    assert np.allclose(np.abs(clip.rates[0, :, node]), 2 * np.pi * 40.0, rtol=1e-12)
    assert np.allclose(np.abs(clip.rates[1, :, node]), (2 * np.pi) ** 2 * 40.0, rtol=1e-12)
    assert np.allclose(clip.rates[1, :, node], -((2 * np.pi) ** 2) * clip.positions[:, node], rtol=1e-9)


def test_a_limit_is_marked_where_it_is():
    """The Chebyshev linkage reaches its limit where coupler and rocker are in line: motor = 101.537 deg."""
    lengths = {"a": 5.0, "b": 5.0, "c": 2.0, "d": 4.0}  # crank, rocker, coupler, frame
    cosine = (lengths["a"] ** 2 + lengths["d"] ** 2 - (lengths["b"] - lengths["c"]) ** 2) / (2 * 5.0 * 4.0)
    lower = math.degrees(math.acos(cosine))
    found = gimcli.trace(model("chebyshev", law={"from": 60, "to": 30}), 30)
    (event,) = found.animation().clips[0].events
    assert event.kind == "limit"
    assert event.row == pytest.approx(60 - lower, abs=1e-6)
    assert event.text == f"limit at motor = {lower:.3f} deg".replace("36.870", "36.87")
    assert not found.animation().clips[0].closed


def test_closed_motions_go_round():
    assert gimcli.trace(model("crank_rocker"), 24).animation().clips[0].closed
    assert not gimcli.trace(model("excavator"), 24).animation().clips[0].closed


def test_a_long_motion_is_thinned_and_says_so():
    found = gimcli.trace(model("crank_rocker"), 30_000)
    motion = found.animation()
    clip = motion.clips[0]
    steps = clip.table["step"]
    assert MOST_ROWS / 2 <= len(clip.time) <= MOST_ROWS + 10
    assert (steps[0], steps[-1]) == (0, 30_000)
    assert np.array_equal(clip.table["P.x"], found["P.x"][steps])
    assert motion.notes[0].startswith(f"{len(clip.time)} of 30001 rows")


def test_thinning_keeps_the_ends_of_gaps():
    good = np.ones(50_000, dtype=bool)
    good[20_001:20_003] = False
    rows = set(shown_rows(good, [33_333.4]).tolist())
    assert {0, 20_000, 20_001, 20_002, 20_003, 33_333, 33_334, 49_999} <= rows


def test_circuits_without_time_have_no_velocities():
    motion = gimcli.trace(model("chebyshev"), 40, circuit=True).animation()
    assert motion.clips[0].rates is None
    assert "no velocities" in motion.clips[0].without
    assert {event.kind for event in motion.clips[0].events} == {"limit"}


@pytest.mark.parametrize("name", ["chebyshev", "parallelogram"])
def test_singular_positions_have_a_row(name):
    """The row of each event has the positions that the command lists."""
    found = gimcli.singularities(model(name))
    motion = found.animation()
    assert len(motion.clips) == len(found.report()["circuits"])
    for number, clip in enumerate(motion.clips, start=1):
        own = [event for event in found.events if number in event["branches"]]
        assert len(own) == len(clip.events)
        for event in own:
            z = np.array([complex(*place) for place in event["nodes"].values()])
            near = np.max(np.abs(clip.positions - z), axis=1)
            rows = [round(moment.row) for moment in clip.events if moment.kind == event["kind"]]
            assert min(near[row] for row in rows) < 1e-7 * found.mechanism.scale
        steps = np.max(np.abs(np.diff(clip.positions, axis=0)), axis=1)
        assert np.max(steps) < 3.0 * np.median(steps)  # each row is between its neighbours


def test_simulated_rows_and_standstills():
    found = gimcli.simulate(model("watt_durango"), 2.0, dt=0.01, rtol=1e-6)
    clip = found.animation().clips[0]
    assert clip.forward
    assert np.allclose(clip.positions[:, 3], found.xy["B"] @ [1, 1j])
    (event,) = clip.events
    assert event.row * 0.01 == pytest.approx(found.events[0]["time"])
    change = (clip.positions[2:] - clip.positions[:-2]) / 0.02
    assert np.max(np.abs(change - clip.rates[0, 1:-1])) < 0.02 * np.max(np.abs(clip.rates[0]))


def test_each_configuration_is_a_clip():
    found = gimcli.configurations(model("ten_bar"))
    motion = found.animation()
    assert len(motion.clips) == found.count
    assert sum("initial" in clip.name for clip in motion.clips) == 1
    for k, clip in enumerate(motion.clips):
        assert clip.positions[0, 4] == complex(*found.xy[found.mechanism.nodes[4]][k])


def test_results_without_a_motion_have_no_page(tmp_path):
    nothing = gimcli.solve(model("crank_rocker", law={"from": 0, "to": 90}), motor=0)
    assert nothing.animation() is not None
    far = gimcli.load(MODELS / "chebyshev.yaml")
    assert gimcli.configurations(far, motor=200).animation() is None
    with pytest.raises(gimcli.UsageError):
        gimcli.configurations(far, motor=200).save(tmp_path / "a.html")
    with pytest.raises(gimcli.UsageError):
        gimcli.mobility(far).save(tmp_path / "a.html")


def test_graphs_of_plot_come_first():
    found = gimcli.trace(model("crank_rocker"), 12, measure="transmission", plot="transmission,omega")
    first, second = found.animation().graphs
    assert all(name.startswith("transmission:") for name in first.columns)
    assert second.columns == ("crank.omega", "coupler.omega", "rocker.omega")


def test_texts_are_inert():
    hostile = "</script><script>alert(1)</script>\u2028<!--"
    section = Section(hostile, (hostile,), [(hostile,), (hostile,)], warnings=(hostile,))
    found = gimcli.trace(model("crank_rocker"), 4).animation()
    from dataclasses import replace

    motion = replace(found, title=hostile, notes=(hostile,), report=(section,))
    text = page_json(motion)
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text)["report"][0]["table"]["rows"] == [[hostile], [hostile]]
    document = page(motion)
    assert document.count("<script") == 2
    assert document.count("</script") == 2
    assert "<!--" not in document


def test_policy_has_the_hashes_of_style_and_scripts():
    document = page(gimcli.trace(model("crank_rocker"), 4).animation(), scripts=("gim.set({row: 2});",), connect=True)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', document)[1]
    for text in re.findall(r"<(?:script|style)>(.*?)</(?:script|style)>", document, re.DOTALL):
        assert base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() in policy
    assert len(re.findall("'sha256-", policy)) == 3
    assert policy.startswith("default-src 'none'; ")
    assert "connect-src 'self'" in policy
    assert "unsafe" not in policy
    assert not re.search(r"""(?:src|href)=["'](?!data:)""", document)


def test_size_of_the_ten_bar(tmp_path):
    path = tmp_path / "ten_bar.html"
    assert gim("trace", MODELS / "ten_bar.yaml", "-n", 360, "-d", 3, "--plot", "velocity,omega", "-o", path).code == 0
    assert path.stat().st_size <= 500_000


def test_a_page_needs_no_matplotlib_and_a_table_no_page(tmp_path):
    """What is not asked for is not imported."""
    code = (
        "import sys, gimcli; found = gimcli.trace(gimcli.load(sys.argv[1]), 8); found.table(); found.report();"
        "early = [name for name in sys.modules if 'animation' in name or 'output.page' in name];"
        "found.save(sys.argv[2]); sys.exit(bool(early or {'matplotlib', 'numba', 'typer'} & set(sys.modules)))"
    )
    command = [sys.executable, "-c", code, str(MODELS / "crank_rocker.yaml"), str(tmp_path / "a.html")]
    assert subprocess.run(command, check=False, timeout=60).returncode == 0
