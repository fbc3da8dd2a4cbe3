"""scripts/image: what it asks of buildah, which is one of our own here, as is mmdebstrap."""

import os
import subprocess
import tomllib
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]

RECORDS = """#!/bin/bash
printf "%s|" "${0##*/}" "$@" >>"$FAKE/calls"; echo >>"$FAKE/calls"
"""
BUILDAH = (
    RECORDS
    + """
shift 6  # where it stores
case $1 in
    inspect) [[ -e $FAKE/image ]] || exit 1 ;;
    build)
        for argument; do
            [[ $argument != *:/etc/apt/sources.list:ro ]] || cp "${argument%%:*}" "$FAKE/seen"
        done
        [[ ! -e $FAKE/fails ]] || { echo "E: Unable to locate package nonsense" >&2; exit 100; }
        touch "$FAKE/image" ;;
    from) echo container ;;
esac
"""
)
APT_GET = """#!/bin/sh
echo "'http://mirror/debian/dists/bookworm/InRelease' mirror_1 0"
"""


class Machine:
    """A machine whose buildah only writes down what it is asked."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "commands").mkdir()
        commands = {"buildah": BUILDAH, "mmdebstrap": RECORDS, "apt-get": APT_GET}
        for name, script in (commands | {"bwrap": "#!/bin/sh\n"}).items():
            path = folder / "commands" / name
            path.write_text(script)
            path.chmod(0o755)
        self.data = folder / "data"
        self.data.mkdir()

    def image(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [str(CHECKOUT / "scripts" / "image"), *arguments],
            cwd=self.data,
            env=os.environ
            | {
                "FAKE": str(self.folder),
                "XDG_CACHE_HOME": str(self.folder / "cache"),
                "PATH": f"{self.folder}/commands:/usr/bin:/bin:/usr/sbin:/sbin",
            },
            capture_output=True,
            text=True,
            timeout=60,
        )

    def calls(self, command: str) -> list[list[str]]:
        lines = (self.folder / "calls").read_text().splitlines()
        return [line.split("|") for line in lines if line.startswith(f"{command}|")]

    def buildah(self, verb: str) -> list[str]:
        (call,) = (call[7:] for call in self.calls("buildah") if call[7:][:1] == [verb])
        return call


def can_have_namespaces() -> bool:
    owner = [] if os.getuid() == 0 else ["--map-root-user", "--map-auto"]
    command = ["unshare", *owner, "--mount", "--pid", "--mount-proc", "--fork", "true"]
    return subprocess.run(command, capture_output=True).returncode == 0


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    if not can_have_namespaces():
        pytest.skip("no namespaces may be made here")
    return Machine(tmp_path)


def test_the_build_sees_the_mirror_of_this_machine_and_nothing_keeps_it(machine):
    result = machine.image("build")
    assert (result.returncode, result.stdout) == (0, "")
    assert "http://mirror/debian trixie main" in (machine.folder / "seen").read_text()
    kept = [path for path in (machine.folder / "cache").rglob("*") if path.is_file()]
    assert not [path for path in kept if "mirror" in path.read_text()]
    (mmdebstrap,) = machine.calls("mmdebstrap")
    assert "--variant=minbase" in mmdebstrap
    assert any("rm -f" in word and "sources.list" in word for word in mmdebstrap)


def test_the_image_is_told_its_commit(machine):
    machine.image("build")
    command = ["git", "-C", str(CHECKOUT), "describe", "--always", "--dirty"]
    commit = subprocess.run(command, capture_output=True, text=True).stdout.strip()
    assert f"GIT_COMMIT={commit}" in machine.buildah("build")


def test_a_failed_build_is_one_last_line(machine):
    (machine.folder / "fails").touch()
    result = machine.image("build")
    assert result.returncode == 1
    assert "E: Unable to locate package nonsense" in result.stderr.splitlines()[-1]


def test_a_command_runs_as_the_owner_of_its_folder(machine):
    machine.image("build")
    if os.getuid() == 0:
        os.chown(machine.data, 1234, 5678)
    machine.image("run", "bilayer", "--set", "two words")
    call = machine.buildah("run")
    owner = "1234:5678" if os.getuid() == 0 else "0:0"
    assert call[call.index("--user") + 1] == owner
    assert f"{machine.data}:/data" in call
    assert call[call.index("--") + 1 :][:3] == ["bilayer", "--set", "two words"]


@pytest.mark.parametrize("arguments", [["run", "true"], ["save", "image.tar"]])
def test_without_an_image_one_line_says_how_to_make_it(machine, arguments):
    result = machine.image(*arguments)
    assert result.returncode == 1
    assert result.stderr.count("\n") == 1
    assert "make it with: scripts/image build" in result.stderr


@pytest.mark.parametrize("arguments", [["buid"], ["run"], ["save"], ["build", "now"]])
def test_bad_arguments_are_one_line_and_status_2(machine, arguments):
    result = machine.image(*arguments)
    assert result.returncode == 2
    assert result.stderr.count("\n") == 1
    assert "expected" in result.stderr


def test_the_dockerfile_copies_every_package():
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())
    include = project["tool"]["setuptools"]["packages"]["find"]["include"]
    folders = {pattern.removesuffix("*") for pattern in include}
    lines = (CHECKOUT / "docker" / "Dockerfile").read_text().splitlines()
    copied = {line.split()[1] for line in lines if line.startswith("COPY ")}
    assert (
        folders | {"docker/apt-packages.txt", "docker/python-packages.txt", "pyproject.toml"}
        <= copied
    )
