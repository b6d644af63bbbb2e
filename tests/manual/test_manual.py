"""The manual: all blocks of its pages and of README run, all links lead somewhere, `gim manual` shows it."""

import re
import subprocess
import sys
from unittest.mock import patch

import pytest
from bundled import MANUAL, README, ROOT
from fences import PAGES, Reader
from in_process import printed, refused

from gimcli.cli import COMMANDS
from gimcli.dynamics.integrators import INTEGRATORS
from gimcli.manual.pages import command_names, manual_text, page_names, summary
from gimcli.output import FORMATS
from gimcli.quantities.kinds import KINDS

REGISTRIES = (INTEGRATORS, KINDS, FORMATS)


@pytest.fixture
def registries():
    """Forget what a page registers."""
    patches = [patch.dict(registry) for registry in REGISTRIES]
    for one in patches:
        one.start()
    yield
    for one in patches:
        one.stop()


def name(page):
    return page.stem


@pytest.mark.usefixtures("registries", "unrendered")
@pytest.mark.parametrize("page", PAGES, ids=name)
def test_blocks_run(page, tmp_path):
    Reader(tmp_path).read(page)


@pytest.mark.soak
@pytest.mark.usefixtures("registries")
@pytest.mark.parametrize("page", PAGES, ids=name)
def test_all_blocks_run(page, tmp_path):
    Reader(tmp_path, soak=True).read(page)


def prose(page):
    """Return the text of a page without its blocks."""
    return re.sub(r"(?ms)^```.*?^```$", "", page.read_text(encoding="utf-8"))


def anchors(page):
    """Return the anchors of a page's headings, as GitHub makes them."""
    heads = re.findall(r"(?m)^#+ (.*)$", prose(page))
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if not target.startswith(("http://", "https://")):
            path, _, anchor = target.partition("#")
            file = page.parent / path if path else page
            assert file.exists(), target
            assert not anchor or anchor in anchors(file), target


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_lines_have_at_most_120_characters(page):
    lines = page.read_text(encoding="utf-8").splitlines()
    long = [k for k, line in enumerate(lines, 1) if len(line) > 120 and not line.startswith("|")]
    assert not long


def test_readme_is_short():
    assert len(README.read_text(encoding="utf-8").splitlines()) <= 150


@pytest.mark.parametrize("page", sorted(MANUAL.glob("*.md")), ids=name)
def test_a_page_has_a_title_a_summary_and_links_to_it(page):
    assert page.read_text(encoding="utf-8").startswith("# ")
    assert 10 < len(summary(page.stem)) < 120
    assert page.stem == "index" or f"]({page.name})" in (MANUAL / "index.md").read_text(encoding="utf-8")
    assert f"](gimcli/manual/{page.name}" in README.read_text(encoding="utf-8")


def test_the_list_has_every_page():
    listed = printed("manual")
    for page in MANUAL.glob("*.md"):
        assert re.search(rf"(?m)^{page.stem} +{re.escape(summary(page.stem))}$", listed)


def test_a_pipe_gets_markdown_without_links_and_words_for_the_tests():
    page, shown = (MANUAL / "speed.md").read_text(encoding="utf-8"), printed("manual", "speed")
    assert "```bash soak" in page
    assert "](accuracy.md#ill-conditioned-mechanisms)" in page
    assert re.findall(r"(?m)^```.+$", shown) == [re.sub(r" .*", "", f) for f in re.findall(r"(?m)^```.+$", page)]
    assert "the table of ill-conditioned mechanisms" in shown
    assert "](" not in shown
    plain = [line for line in page.splitlines() if line and not re.search(r"\]\(|^```", line)]
    assert set(plain) <= set(shown.splitlines())


def test_every_command_has_a_section():
    assert set(command_names()) == set(COMMANDS)
    for command in COMMANDS:
        assert manual_text(command).startswith(f"## gim {command}\n")


def test_a_name_that_is_no_page_is_refused():
    assert "did you mean 'index'" in refused("manual", "idnex")
    assert "pages: index" in refused("manual", "xyzxyz")
    assert page_names()[0] == "index"


def test_nothing_heavy_is_imported():
    code = (
        "import sys; sys.argv = ['gim', 'manual', 'index']\n"
        "from gimcli.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "heavy = {'numba', 'matplotlib', 'scipy', 'numpy', 'pydantic', 'yaml', 'rich'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, cwd=ROOT)


def test_a_terminal_gets_it_rendered(monkeypatch, capsys):
    """Headings without their signs, links as words, pictures by their names; no pager waits for keys.

    Older versions of rich draw a frame around a title.
    """
    from gimcli.cli.manual import _show

    monkeypatch.setenv("PAGER", "cat")
    _show("# Title\n\nSee [limits](branches.md#x), [python](python.md), [f](../../f.py).\n\n![Alt](../../a/b.png)\n")
    lines = [line.strip(" ┏━┓┃┗┛") for line in capsys.readouterr().out.splitlines()]
    assert [line for line in lines if line] == [
        "Title",
        "See limits (gim manual branches), python, f.",
        "(Picture a/b.png: Alt)",
    ]
