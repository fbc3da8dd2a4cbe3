"""What a process says, on streams that are closed, broken, full or poor, and of texts that lie."""

import ast
import contextlib
import io
import os
import subprocess
import sys
import tomllib
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest
import xarray as xr
from made_results import cap_result, small_specimen

from bilayer.cli.main import main
from bilayer.results.files import write_result
from bilayer.runtime.terminal import one_line, printable, say, tell
from bilayer.specimen.toml import template
from bilayer.validation import nearest
from dshell.settings import PaperSettings

ROOT = Path(__file__).parents[2]


def shell_call(line, folder, **variables):
    """Run a line of bash in which "$P" is this Python."""
    own = os.environ | {"P": f"{sys.executable} -P", "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", line],
        cwd=folder, env=own | variables, capture_output=True, text=True, timeout=120,
    )  # fmt: skip


LIES = "\x1b[2J\nTo run it again:\n  rm -rf ~ \u202e é"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a specimen and a result whose name and reason are made to mislead."""
    path = tmp_path_factory.mktemp("said")
    (path / "s.toml").write_text(template())
    specimen = replace(small_specimen([1.03]), name=f"disc {LIES}")
    write_result(cap_result(specimen, stop_reason=LIES, settings=PaperSettings()), path / "r.nc")
    return path


VERBS = {
    "init": "init",
    "help": "solve --help",
    "version": "--version",
    "info": "info r.nc",
    "specimen": "info r.nc --specimen",
    "mesh": "mesh s.toml --mesh-size 0.02 -o m.vtu",
    "plot": "plot r.nc -o p.png",
    "compare": "compare r.nc r.nc",
    "convert": "convert r.nc --all -o c.vtu",
    "export": "export s.toml --mesh-size 0.02 --prestretch 1.03 -o d.inp",
    "solve": "solve s.toml --solver dshell --model paper --set solver.total_time=0.002 "
    "--mesh-size 0.02 --prestretch 1.01 -o q.nc",
    "unknown": "solv",
    "missing": "info none.nc",
}


def status_of(words):
    try:
        return main(words.split())
    except SystemExit as end:
        return end.code


@contextlib.contextmanager
def stream_to(descriptor, *names):
    """Let some of the streams lead to a file or a descriptor, as Python makes them."""
    stream = io.TextIOWrapper(open(descriptor, "wb"), encoding="utf-8")  # noqa: SIM115, PTH123
    with pytest.MonkeyPatch.context() as patch:
        for name in names:
            patch.setattr(sys, name, stream)
        yield
    with contextlib.suppress(OSError):
        stream.close()


@pytest.mark.parametrize("verb", VERBS)
def test_a_reader_who_has_gone_is_no_error(folder, monkeypatch, verb):
    monkeypatch.chdir(folder)
    reader, writer = os.pipe()
    os.close(reader)
    with stream_to(writer, "stdout", "stderr"):
        status = status_of(VERBS[verb])
    assert status == (2 if verb in ("unknown", "missing") else 0)


@pytest.mark.parametrize("verb", ["init", "help", "version", "info", "compare"])
def test_a_full_disk_behind_stdout_is_one_line(folder, monkeypatch, capsys, verb):
    monkeypatch.chdir(folder)
    with stream_to("/dev/full", "stdout"):
        assert status_of(VERBS[verb]) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "No space left" in told


@pytest.mark.parametrize("closed", ["<&- >&- 2>&-", "2>&1 | true"])
def test_closed_streams_change_nothing(folder, closed):
    """From the start of a process on: PETSc, too, must not end at a broken pipe."""
    code = "from petsc4py import PETSc; " if find_spec("petsc4py") else ""
    start = f"from bilayer.runtime.petsc import start_petsc; start_petsc(); {code}"
    code = f"{start}import sys; from bilayer.__main__ import main; sys.exit(main())"
    done = shell_call(f"rm -f q.nc; $P -c '{code}' {VERBS['solve']} {closed}", folder)
    assert done.returncode == 0
    assert "Traceback" not in done.stderr
    with xr.open_dataset(folder / "q.nc") as written:  # what is printed must not land in it
        assert written.attrs["solver"] == "dshell"


def test_a_stream_of_ascii_alone_gets_the_rest_written_out(folder):
    poor = {"PYTHONIOENCODING": "ascii:strict", "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0",
            "PYTHONUTF8": "0"}  # fmt: skip
    done = shell_call("$P -m bilayer info r.nc", folder, **poor)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii()


def test_nothing_in_a_file_makes_lines_or_moves_the_cursor(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    assert main(["info", "r.nc"]) == 0
    told = capsys.readouterr().out
    assert told.count("\nTo run it again") == 1
    assert "\\u001b[2J\\nTo run it again" in told
    assert all(letter.isprintable() or letter == "\n" for letter in told)


def test_a_specimen_that_is_shown_reads_back_the_same(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    assert main(["info", "r.nc", "--specimen"]) == 0
    told = capsys.readouterr().out
    assert tomllib.loads(told)["specimen"]["name"] == f"disc {LIES}"
    assert all(letter.isprintable() or letter == "\n" for letter in told)


@pytest.mark.parametrize("name", ["\x1b]0;owned\x07.nc", "a\nbilayer: error: b.nc", "\udcff.nc"])
def test_an_error_is_one_line_whatever_is_named(capsys, name):
    assert main(["info", name]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert told[:-1].isprintable()


@pytest.mark.parametrize("letter", ["\x07", "\x1b", "\x7f", "\x9b", "\u2028", "\u202e", "\udc80"])
def test_what_is_not_printed_is_written_out(letter):
    assert printable(f"a{letter}b\n") == f"a\\u{ord(letter):04x}b\n"
    assert one_line(f"a{letter}\n") == f"a\\u{ord(letter):04x}\\n"


@pytest.mark.parametrize("words", ["--verbose info a.nc", "info a.nc --verbose",
                                   "--verbose info --quiet a.nc"])  # fmt: skip
def test_options_of_all_verbs_stand_before_or_after(words, capsys):
    assert main(words.split()) == 2
    assert "Traceback" in capsys.readouterr().err


def test_quiet_before_a_verb_is_quiet(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    assert main(["--quiet", *VERBS["solve"].split()]) == 0
    captured = capsys.readouterr()
    assert captured.out + captured.err == ""


@pytest.mark.parametrize(
    ("words", "suggested"),
    [
        (["solv"], "'solve'"),
        (["olve"], "'solve'"),
        (["inof"], "'info'"),
        (["solve", "s.toml", "--solver", "fenic", "-o", "a.nc"], "'fenics'"),
        (["solve", "s.toml", "--solver", "fenics", "-o", "a", "--prestrech"], "'--prestretch'"),
        (["nonsense"], None),
        (["solve", "s.toml", "--nothing-like-it"], None),
    ],
)  # fmt: skip
def test_what_is_near_is_suggested(words, suggested, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(words)
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert (suggested is None) == ("did you mean" not in told)
    assert suggested is None or f"did you mean {suggested}?" in told


@pytest.mark.parametrize(
    ("name", "known", "suggested"),
    [
        ("gif", ["png", "pdf", "tif"], ""),
        ("pgn", ["png", "pdf", "tif"], "png"),
        ("docx", ["png", "svg"], ""),
        ("x" * 10**7, ["size", "x"], ""),
        (None, ["none"], ""),
    ],
)
def test_nothing_far_is_suggested(name, known, suggested):
    found = nearest(name, known)
    assert found == (f"; did you mean {suggested!r}?" if suggested else "")


@pytest.mark.parametrize("package", ["bilayer", "dshell", "fenics_model"])
def test_nothing_else_writes_to_a_stream(package):
    for file in (ROOT / package).rglob("*.py"):
        nodes = ast.walk(ast.parse(file.read_text()))
        calls = [node for node in nodes if isinstance(node, ast.Call)]
        prints = [node.lineno for node in calls if getattr(node.func, "id", "") == "print"]
        assert file.name == "terminal.py" or not prints, f"{file}: {prints}"


class Screen(io.StringIO):
    """A terminal."""

    def isatty(self):
        return True


def have_screens(monkeypatch):
    """Put terminals in place of stdout and stderr."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setattr("sys.stdout", Screen())
    monkeypatch.setattr("sys.stderr", Screen())


def test_a_terminal_gets_errors_and_alarms_in_colour(monkeypatch):
    have_screens(monkeypatch)
    tell("bilayer: error: the word error: is here again")
    say("NOT STABLE at 1.06, E of \x1b[31m")
    assert sys.stderr.getvalue() == (
        "bilayer: \x1b[1;31merror\x1b[0m: the word error: is here again\n"
    )
    assert sys.stdout.getvalue() == "\x1b[1;33mNOT STABLE\x1b[0m at 1.06, E of \\u001b[31m\n"


@pytest.mark.parametrize(("name", "value"), [("NO_COLOR", "1"), ("TERM", "dumb")])
def test_a_user_who_wants_no_colour_gets_none(monkeypatch, name, value):
    have_screens(monkeypatch)
    monkeypatch.setenv(name, value)
    tell("bilayer: error: no")
    say("NOT STABLE")
    assert sys.stderr.getvalue() + sys.stdout.getvalue() == "bilayer: error: no\nNOT STABLE\n"


def test_a_file_gets_no_colour(capsys):
    tell("bilayer: warning: no")
    say("NOT STABLE")
    assert "\x1b" not in "".join(capsys.readouterr())
