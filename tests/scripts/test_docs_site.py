"""The site: it builds without a fault, its commands are ones, its links and blocks are checked."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from documentation.blocks import Block, blocks_of, commands_of, run_page, shell_script
from documentation.links import faults
from documentation.reference import verb_parser, verb_text, written_texts
from documentation.staging import CHECKOUT, stage

from bilayer.cli.verbs import VERBS

PAGES = [CHECKOUT / "README.md", *sorted((CHECKOUT / "docs").rglob("*.md"))]
EXAMPLES = sorted((CHECKOUT / "examples" / "gallery").rglob("plot_*.py"))
PAGE = """
<!-- before: touch made -->
```toml
# a.toml
x = 1
```

```bash
grep -q 1 a.toml && test -f made
```

<!-- not run: it would fail -->
```bash
false
```

```python
assert open("a.toml").read() == "# a.toml\\nx = 1\\n"
```
"""


@pytest.mark.slow
def test_the_fast_site_has_no_fault(tmp_path, capfd):
    pytest.importorskip("sphinx_gallery")
    from build_docs import main

    assert main(["--fast", "--folder", str(tmp_path)]) == 0, capfd.readouterr().err
    assert ", 0 dead links" in capfd.readouterr().out
    page = (tmp_path / "html" / "reference" / "api" / "bilayer.solve.html").read_text()
    assert "Compute the shapes of a specimen" in page
    assert not list((CHECKOUT / "docs").rglob("*.rst.txt"))  # nothing is written beside the pages


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(CHECKOUT)))
def test_the_commands_of_a_page_are_ones(page):
    for command in commands_of(page.read_text(encoding="utf-8")):
        verb, *words = shlex.split(command)
        if verb in VERBS:
            verb_parser(verb).parse_args(words)  # exits with status 2 if it is none


def test_a_command_that_is_none_is_found():
    (command,) = commands_of(
        "```bash\nbilayer solve a.toml \\\n    --solvr dshell  # seconds\n```\n"
    )
    assert command == "solve a.toml --solvr dshell"
    with pytest.raises(SystemExit):
        verb_parser("solve").parse_args(command.split()[1:])


def test_every_option_of_a_verb_is_told():
    text = verb_text("solve")
    assert text.startswith("## solve\n\nCompute the released shapes")
    assert "| `--start START` |" in text
    assert "`--quiet`" not in text


def test_every_setting_is_told_with_its_default():
    text = written_texts()["the settings"]
    assert "| `solver.contact_range` | `0.1` |" in text


def test_blocks_of_a_page_run_in_order(tmp_path):
    assert list(blocks_of(PAGE))[3] == Block("bash", "false\n", run=False)
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    assert run_page(page) == ""
    page.write_text(PAGE.replace("x = 1\n```", "x = 2\n```"))
    assert "grep -q 1 a.toml" in run_page(page)
    assert shell_script("```bash\n```\n").startswith("set -euo pipefail")


def test_dead_links_are_found(tmp_path):
    (tmp_path / "a.html").write_text('<h1 id="top"></h1><a href="b.html#here"></a><a href="#top">')
    (tmp_path / "b.html").write_text('<a id="there"></a><img src="http://x.org/a.png"><a href="c">')
    found = list(faults(Path(tmp_path)))
    assert found == [
        "a.html: b.html#here: has no such place",
        "b.html: c: is not there",
        "b.html: http://x.org/a.png: is loaded over the network",
    ]


def test_a_staged_page_links_pages_of_the_site(tmp_path):
    pages = stage(tmp_path / "source", {"the verbs": "VERBS"})
    assert "VERBS" in (pages / "reference" / "command-line.md").read_text()
    assert "[](environment.md)" in (pages / "usage.md").read_text()
    assert "(gallery/index.rst)" in (pages / "index.md").read_text()


@pytest.mark.parametrize("example", ["1-paper/plot_1_mesh", "4-evidence/plot_material_fit"])
def test_an_example_of_the_gallery_runs(example, tmp_path):
    script = CHECKOUT / "examples" / "gallery" / f"{example}.py"
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    subprocess.run([sys.executable, script], cwd=tmp_path, env=environment, check=True)
    (picture,) = tmp_path.glob("*.png")
    assert picture.stat().st_size > 10_000


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_checks_a_number_and_ends_in_a_picture(example):
    text = example.read_text(encoding="utf-8")
    assert "\nassert " in text
    assert text.rstrip().splitlines()[-1].startswith(("bilayer.save_figure(", "figure.savefig("))


def test_the_gallery_has_enough_examples():
    assert len(EXAMPLES) >= 15
