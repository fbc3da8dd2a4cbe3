"""scripts/env and scripts/ccx: which way they take, what a command sees inside, how a root is made.

The making is tested with a `mmdebstrap` of our own on the PATH, which takes a second, counts its
runs and does as it is told; the entering with the real bubblewrap, into a root that is this system
seen again.
"""

import os
import pwd
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
ENV = CHECKOUT / "scripts" / "env"
PACKAGES = CHECKOUT / "docker" / "apt-packages.txt"

FAKE_MMDEBSTRAP = """#!/bin/bash
echo run >>"$FAKE/runs"
printf "%s\\n" "$@" >"$FAKE/arguments"
folder=${@: -1}
for argument; do [[ $argument == /*/root-* ]] && folder=$argument; done
mkdir -p "$folder/usr/bin" "$folder/var/cache/apt/archives"
for hook; do [[ $hook != --setup-hook=* ]] || sh -c "${hook#*=}" exec "$folder"; done
ls "$folder/var/cache/apt/archives" >"$FAKE/given"
touch "$folder/var/cache/apt/archives/made.deb" "$FAKE/begun"
[[ ! -e $FAKE/fails ]] || { cat "$FAKE/fails"; exit 1; }
sleep "$(cat "$FAKE/seconds")"
rm "$folder"/var/cache/apt/archives/*.deb
touch "$folder/usr/bin/python3"
"""

# What mmdebstrap says when a package of the list does not exist
FAILED_BUILD = """\
dpkg: regarding .../base-files_13.8_amd64.deb containing base-files, pre-dependency problem:
dpkg: warning: ignoring pre-dependency problem!
E: Package 'nonsense' has no installation candidate
E: apt-get --yes install nonsense failed: process exited with 100
E: mmdebstrap failed to run
"""


def can_make_mounts() -> bool:
    """Whether this user may make mounts here, which an unprivileged container forbids."""
    command = ["bwrap", "--dev-bind", "/", "/", "true"]
    return shutil.which("bwrap") is not None and subprocess.run(command).returncode == 0


needs_mounts = pytest.mark.skipif(not can_make_mounts(), reason="no mounts may be made here")


def run(*arguments: str | Path, **variables: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(ENV), *map(str, arguments)],
        env=os.environ | {"BILAYER_SUITE": ""} | variables,
        capture_output=True,
        text=True,
        timeout=60,
    )


def is_one_line(text: str) -> bool:
    return text.count("\n") == 1 and text.endswith("\n")


# ---------------------------------------------------------------- which way


def test_help_names_the_variable_and_an_example():
    result = run("--help")
    assert result.returncode == 0
    assert "BILAYER_ENV" in result.stdout
    assert "Example: scripts/env" in result.stdout


def test_where_says_the_forced_choice_and_makes_nothing(tmp_path):
    native = run("--where", BILAYER_ENV="native")
    root = run("--where", BILAYER_ENV="root", XDG_CACHE_HOME=str(tmp_path))
    assert native.stdout.startswith("native: ")
    assert root.stdout.startswith(f"root: {tmp_path}/bilayer-shells/root-")
    assert "not built yet" in root.stdout
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("version", "way"), [
    ("0.8.0", "root"), ("0.9.0", "native"), ("0.11.0.post1", "native"), ("0.12.0", "root"),
])  # fmt: skip
def test_native_is_taken_for_a_supported_dolfinx_only(tmp_path, version, way):
    for module in ("dolfinx", "petsc4py"):
        (tmp_path / f"{module}.py").touch()
    metadata = tmp_path / f"fenics_dolfinx-{version}.dist-info" / "METADATA"
    metadata.parent.mkdir()
    metadata.write_text(f"Metadata-Version: 2.1\nName: fenics-dolfinx\nVersion: {version}\n")
    result = run("--where", BILAYER_ENV="", PYTHONPATH=str(tmp_path), HOME=str(tmp_path))
    assert result.stdout.startswith(way)


def test_root_is_taken_where_python_is_missing(tmp_path):
    for command in ("bash", "dirname", "readlink", "sha256sum", "cut", "sed", "sort", "uname"):
        (tmp_path / command).symlink_to(shutil.which(command))
    result = run("--where", BILAYER_ENV="", PATH=str(tmp_path), HOME=str(tmp_path))
    assert result.stdout.startswith("root: ")


@pytest.mark.parametrize(
    ("arguments", "choice"),
    [
        (["true"], "docker"),
        (["true"], "/nowhere"),
        (["--wher"], "native"),
        (["--rebuild"], "native"),
    ],
)
def test_bad_choice_is_one_line_and_status_2(arguments, choice):
    assert_refused(run(*arguments, BILAYER_ENV=choice))


@pytest.mark.parametrize("suite", ["bookworm", "trixie/..", "--help"])
def test_bad_suite_is_one_line_and_status_2(suite):
    assert_refused(run("true", BILAYER_SUITE=suite))


def assert_refused(result: subprocess.CompletedProcess[str]) -> None:
    assert result.returncode == 2
    assert is_one_line(result.stderr)
    assert "expected" in result.stderr
    assert result.stdout == ""


# ---------------------------------------------------------------- the list


def test_every_package_has_its_reason_and_a_fast_blas_is_among_them():
    lines = [line for line in PACKAGES.read_text().splitlines() if line and line[0] != "#"]
    packages = [line.split()[0] for line in lines]
    assert all(len(line.partition("# ")[2]) > 5 for line in lines)
    assert len(set(packages)) == len(packages)
    assert {"python3-dolfinx", "libopenblas0-serial", "python3-slepc4py"} <= set(packages)


def test_openblas_is_what_petsc_and_numpy_get():
    pytest.importorskip("dolfinx")
    code = "import petsc4py.PETSc, numpy.linalg; print(open('/proc/self/maps').read())"
    maps = run("python3", "-c", code, BILAYER_ENV="native").stdout
    libraries = {Path(line.split()[-1]).resolve() for line in maps.splitlines() if "/lib" in line}
    blas = [str(path) for path in libraries if path.name.startswith(("libblas", "liblapack.so"))]
    assert blas
    assert all("openblas" in path for path in blas)


# ---------------------------------------------------------------- a command in an environment


@pytest.fixture
def root_of_this_system(tmp_path: Path) -> Path:
    """A root file system whose folders are this system's."""
    root = tmp_path / "root"
    (root / "var" / "lib").mkdir(parents=True)
    for folder in ("usr", "etc", "var/lib/dpkg"):
        (root / folder).symlink_to(f"/{folder}")
    for name in ("bin", "sbin", "lib", "lib64"):
        (root / name).symlink_to(f"usr/{name}")
    return root


@pytest.fixture(params=["native", pytest.param("root", marks=needs_mounts)])
def way(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        return "native"
    return str(request.getfixturevalue("root_of_this_system"))


def test_arguments_and_exit_status_pass_through(way):
    result = run(
        "bash", "-c", 'printf "%s|" "$@"; exit 7', "_", "two words", "", "*", "--", BILAYER_ENV=way
    )
    assert result.stdout == "two words||*|--|"
    assert result.returncode == 7
    assert result.stderr == ""


def test_nested_call_runs_directly(way):
    result = run(ENV, "bash", "-c", f"echo $BILAYER_ENV; {ENV} --where; exit 9", BILAYER_ENV=way)
    assert result.stdout.startswith("native\nnative: ")
    assert result.returncode == 9


def test_standard_input_reaches_the_command(way):
    result = subprocess.run(
        [ENV, "cat"],
        env=os.environ | {"BILAYER_ENV": way},
        input=b"3 strips\n",
        capture_output=True,
    )
    assert result.stdout == b"3 strips\n"


def test_folders_have_the_paths_that_they_have_outside(way, tmp_path):
    folder = tmp_path / "a folder"
    home = tmp_path / "home"
    folder.mkdir()
    home.mkdir()
    script = 'pwd; echo shape >here; echo home >"$HOME/there"; ls -d /sys/class /dev/shm /proc/self'
    result = subprocess.run(
        [ENV, "bash", "-c", script],
        cwd=folder,
        env=os.environ | {"BILAYER_ENV": way, "HOME": str(home)},
        capture_output=True,
        text=True,
    )
    assert result.stdout.split("\n")[0] == str(folder)
    assert (result.returncode, result.stderr) == (0, "")
    assert (folder / "here").read_text() == "shape\n"
    assert (home / "there").read_text() == "home\n"


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_signals_reach_the_command(way, sent, tmp_path):
    code = (
        "import signal, sys, time\n"
        f"signal.signal({int(sent)}, lambda *_: sys.exit(33))\n"
        "print('ready', flush=True)\n"
        # in short steps: Python may see a signal only after the call that it came just before
        "for _ in range(3000): time.sleep(0.01)\n"
    )
    process = subprocess.Popen(
        [ENV, "python3", "-c", code],
        env=os.environ | {"BILAYER_ENV": way},
        stdout=subprocess.PIPE,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    process.send_signal(sent)
    assert process.wait(timeout=10) == 33


def test_one_thread_unless_the_user_says_otherwise(way):
    def threads(**variables: str) -> str:
        return run("sh", "-c", "echo $OMP_NUM_THREADS $OPENBLAS_NUM_THREADS", **variables).stdout

    assert threads(BILAYER_ENV=way, OMP_NUM_THREADS="", OPENBLAS_NUM_THREADS="") == "1 1\n"
    assert threads(BILAYER_ENV=way, OMP_NUM_THREADS="3", OPENBLAS_NUM_THREADS="") == "3 1\n"


def test_the_checkout_is_found_and_hides_nothing_of_the_system(way):
    result = run("bash", "-c", "type -P bilayer env test; echo $PYTHONPATH", BILAYER_ENV=way)
    bilayer, env, test, python_path = result.stdout.splitlines()
    assert Path(bilayer).name == "bilayer"
    assert not env.startswith(str(CHECKOUT))
    assert not test.startswith(str(CHECKOUT))
    assert python_path.split(":")[0] == str(CHECKOUT)


@needs_mounts
def test_the_machines_own_python_and_libraries_stay_outside(root_of_this_system):
    names = ["PYTHONHOME", "VIRTUAL_ENV", "LD_LIBRARY_PATH", "PETSC_DIR", "PYENV_ROOT"]
    result = run("env", BILAYER_ENV=str(root_of_this_system), **dict.fromkeys(names, "/elsewhere"))
    assert "/elsewhere" not in result.stdout


@needs_mounts
def test_nothing_can_be_written_where_it_would_be_lost(root_of_this_system):
    result = run("sh", "-c", "echo x >/lost", BILAYER_ENV=str(root_of_this_system))
    assert result.returncode != 0
    assert not Path("/lost").exists()


@needs_mounts
def test_no_process_stays_behind(root_of_this_system):
    command = "sleep 1; for p in /proc/[0-9]*/cmdline; do tr '\\0' ' ' <$p; echo; done 2>/dev/null"
    result = run("bash", "-c", command, BILAYER_ENV=str(root_of_this_system))
    assert "bash" in result.stdout
    assert not [line for line in result.stdout.splitlines()
                if line.startswith("bwrap") and str(root_of_this_system) in line]  # fmt: skip


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_mpirun_is_quiet(way, ranks):
    pytest.importorskip("mpi4py")
    code = "from mpi4py import MPI; c = MPI.COMM_WORLD; n = c.allreduce(1); c.rank or print(n)"
    result = run("mpirun", "-n", str(ranks), "python3", "-c", code, BILAYER_ENV=way)
    assert result.stdout == f"{ranks}\n"
    assert result.stderr == ""


# ---------------------------------------------------------------- making the root file system


class Machine:
    """A machine with no dolfinx, an empty cache, a fake mmdebstrap and nothing to enter with."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cache = folder / "cache" / "bilayer-shells"
        self.checkout = folder / "checkout"
        shutil.copytree(CHECKOUT / "scripts", self.checkout / "scripts")
        shutil.copytree(PACKAGES.parent, self.checkout / "docker")
        commands = folder / "commands"
        commands.mkdir()
        self.command("mmdebstrap", FAKE_MMDEBSTRAP)
        self.command("bwrap", "#!/bin/sh\necho 1\n")
        self.command("nsenter", '#!/bin/sh\necho "entered"\n')
        self.takes(0)
        self.variables = {
            "BILAYER_ENV": "root",
            "BILAYER_SUITE": "",
            "FAKE": str(folder),
            "XDG_CACHE_HOME": str(folder / "cache"),
            "PATH": f"{commands}:/usr/bin:/bin:/usr/sbin:/sbin",
        }

    def command(self, name: str, script: str) -> None:
        path = self.folder / "commands" / name
        path.write_text(script)
        path.chmod(0o755)

    def takes(self, seconds: float) -> None:
        (self.folder / "seconds").write_text(str(seconds))

    def start(self, *arguments: str, script: str = "env") -> subprocess.Popen[str]:
        return subprocess.Popen(
            [str(self.checkout / "scripts" / script), *(arguments or ["true"])],
            env=os.environ | self.variables,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # a suite started in the background ignores Ctrl-C, and its children would inherit that
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )

    def finish(self, *arguments: str, script: str = "env") -> tuple[int, str, str]:
        return finished(self.start(*arguments, script=script))

    def start_and_wait_until_it_builds(self) -> subprocess.Popen[str]:
        (self.folder / "begun").unlink(missing_ok=True)
        process = self.start()
        deadline = time.monotonic() + 20
        while not (self.folder / "begun").exists():
            assert time.monotonic() < deadline, "the build never began"
            time.sleep(0.02)
        return process

    @property
    def builds(self) -> int:
        return (self.folder / "runs").read_text().count("run")

    @property
    def roots(self) -> list[str]:
        return sorted(path.name for path in self.cache.glob("root-*"))

    @property
    def all_roots(self) -> list[Path]:
        return sorted(self.cache.glob("**/root-*"))

    @property
    def mmdebstrap_arguments(self) -> list[str]:
        return (self.folder / "arguments").read_text().splitlines()


def finished(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    output, errors = process.communicate(timeout=60)
    return process.returncode, output, errors


@pytest.fixture
def machine(tmp_path: Path) -> Iterator[Machine]:
    if os.getuid() == 0 and not can_make_mounts():
        pytest.skip("no mounts may be made here")
    return Machine(tmp_path)


def test_the_first_start_builds_and_the_second_does_not(machine):
    status, output, errors = machine.finish()
    assert (status, output) == (0, "entered\n")
    assert "making a Debian trixie environment" in errors
    assert machine.finish() == (0, "entered\n", "")
    assert machine.builds == 1
    assert len(machine.roots) == 1


def test_a_failed_build_is_one_last_line_and_leaves_nothing(machine):
    (machine.folder / "fails").write_text(FAILED_BUILD)
    status, output, errors = machine.finish()
    assert (status, output) == (1, "")
    assert "failed: E: Package 'nonsense' has no installation" in errors.splitlines()[-1]
    assert machine.roots == []
    (machine.folder / "fails").unlink()
    assert machine.finish()[0] == 0


@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_an_interrupted_build_is_not_trusted_and_its_downloads_are_kept(machine, sent):
    machine.takes(30)
    process = machine.start_and_wait_until_it_builds()
    process.send_signal(sent)
    status, output, _ = finished(process)
    assert status not in (0, None)
    assert output == ""
    machine.takes(0)
    again = machine.start("--where")
    assert "not built yet" in finished(again)[1]
    before = time.monotonic()
    assert machine.finish()[:2] == (0, "entered\n")
    assert time.monotonic() - before < 20, "the killed build went on"
    assert machine.builds == 2
    assert len(machine.roots) == 1
    assert not machine.roots[0].endswith(".partial")


def test_downloads_of_a_broken_build_are_given_to_the_next(machine):
    machine.takes(30)
    process = machine.start_and_wait_until_it_builds()
    process.kill()
    finished(process)
    (machine.folder / "fails").touch()
    machine.finish()
    assert [path.name for path in (machine.cache / "packages").iterdir()] == ["made.deb"]
    assert (machine.folder / "given").read_text() == "made.deb\n"
    (machine.folder / "fails").unlink()
    machine.takes(0)
    machine.finish()
    assert (machine.folder / "given").read_text() == "made.deb\n"
    assert not (machine.cache / "packages").exists()


def test_a_root_that_cannot_be_entered_is_one_line(machine):
    machine.finish()
    machine.command("bwrap", "#!/bin/sh\nexit 1\n")
    status, output, errors = machine.finish()
    assert (status, output) == (1, "")
    assert "bubblewrap could not enter" in errors
    assert is_one_line(errors)


def test_two_starts_at_once_build_once(machine):
    machine.takes(2)
    first = machine.start_and_wait_until_it_builds()
    second = machine.start()
    assert finished(first)[:2] == (0, "entered\n")
    status, output, errors = finished(second)
    assert (status, output) == (0, "entered\n")
    assert "waiting for it" in errors
    assert machine.builds == 1


def test_a_changed_list_rebuilds_and_a_changed_reason_does_not(machine):
    packages = machine.checkout / "docker" / "apt-packages.txt"
    machine.finish()
    before = machine.roots
    packages.write_text(packages.read_text().replace("# progress bars", "# something to look at"))
    machine.finish()
    assert machine.roots == before
    packages.write_text(packages.read_text() + "hello  # one more\n")
    machine.finish()
    assert machine.builds == 2
    assert len(machine.roots) == 1
    assert machine.roots != before


PIP_IN_THE_ROOT = """#!/bin/bash
[[ $* == *" -m pip "* ]] || { echo 1; exit; }
printf "%s\\n" "$@" >"$FAKE/pip"
cat >"$FAKE/requirements"
[[ ! -e $FAKE/no_index ]] || { echo "ERROR: no index"; exit 1; }
"""


def test_python_packages_are_installed_into_the_root_in_their_versions(machine):
    machine.command("bwrap", PIP_IN_THE_ROOT)
    status, output, errors = machine.finish()
    assert (status, output) == (0, "entered\n")
    assert "not installed" not in errors
    (root,) = machine.roots
    folder = "/usr/lib/python3/dist-packages"
    arguments = (machine.folder / "pip").read_text().splitlines()
    binds = zip(arguments, arguments[1:], arguments[2:], strict=False)
    assert ("--bind", f"{machine.cache}/{root}.partial{folder}", folder) in binds
    assert arguments[arguments.index("--target") + 1] == folder
    listed = (machine.checkout / "docker" / "python-packages.txt").read_text().splitlines()
    expected = [line.partition("#")[0].strip() for line in listed]
    wanted = (machine.folder / "requirements").read_text().splitlines()
    assert wanted == sorted(filter(None, expected))
    assert all("==" in line for line in wanted)


def test_without_a_package_index_one_line_says_what_is_missing(machine):
    machine.command("bwrap", PIP_IN_THE_ROOT)
    (machine.folder / "no_index").touch()
    status, output, errors = machine.finish()
    assert (status, output) == (0, "entered\n")
    (line,) = [line for line in errors.splitlines() if "not installed" in line]
    assert "ipctk==" in line
    assert "ERROR: no index" in line
    assert len(machine.roots) == 1


def test_a_changed_list_of_python_packages_rebuilds(machine):
    packages = machine.checkout / "docker" / "python-packages.txt"
    machine.finish()
    before = machine.roots
    packages.write_text(packages.read_text() + "hello==1.0  # one more\n")
    machine.finish()
    assert machine.builds == 2
    assert machine.roots != before


def test_a_root_in_use_is_not_removed(machine):
    machine.finish()
    (in_use,) = machine.roots
    packages = machine.checkout / "docker" / "apt-packages.txt"
    packages.write_text(packages.read_text() + "hello  # one more\n")
    holding = [
        "flock",
        "--shared",
        "--no-fork",
        machine.cache / in_use,
        "sh",
        "-c",
        "echo; sleep 20",
    ]
    with subprocess.Popen(holding, stdout=subprocess.PIPE) as user:
        assert user.stdout is not None
        user.stdout.readline()
        machine.finish()
        roots = machine.roots
        user.kill()
    assert in_use in roots


@needs_mounts
def test_a_running_command_holds_its_root(root_of_this_system):
    lock = ["flock", "--exclusive", "--nonblock", str(root_of_this_system), "true"]
    result = run(*lock, BILAYER_ENV=str(root_of_this_system))
    assert result.returncode != 0
    assert subprocess.run(lock).returncode == 0


def test_rebuild_makes_a_new_root(machine):
    machine.finish()
    (root,) = machine.roots
    (machine.cache / root / "spoiled").touch()
    status, output, _ = machine.finish("--rebuild")
    assert (status, output) == (0, "")
    assert machine.roots == [root]
    assert not (machine.cache / root / "spoiled").exists()


def test_every_suite_keeps_its_root_when_another_is_made(machine):
    machine.finish()
    trixie = machine.all_roots
    machine.variables["BILAYER_SUITE"] = "unstable"
    machine.finish()
    both = machine.all_roots
    assert set(trixie) < set(both)
    machine.finish("--rebuild")
    assert machine.all_roots == both
    machine.variables["BILAYER_SUITE"] = ""
    machine.finish("--rebuild")
    assert machine.all_roots == both
    assert machine.builds == 4


def test_only_a_moving_suite_may_have_an_index_past_its_date(machine):
    ignores_dates = 'Acquire::Check-Valid-Until "false";'
    machine.command("apt-config", "#!/bin/sh\n")
    machine.finish()
    assert ignores_dates not in "".join(machine.mmdebstrap_arguments)
    machine.variables["BILAYER_SUITE"] = "unstable"
    machine.finish()
    assert ignores_dates in "".join(machine.mmdebstrap_arguments)


APT_GET = """#!/bin/sh
cat <<'URIS'
'http://mirror/debian/dists/bookworm/InRelease' mirror_1 0
'http://mirror/debian/dists/bookworm-updates/InRelease' mirror_2 0
'http://mirror/debian-security/dists/bookworm-security/InRelease' mirror_3 0
'http://elsewhere/linux/debian/dists/bookworm/InRelease' elsewhere_1 0
URIS
"""


@pytest.mark.parametrize(("suite", "parts"), [
    ("trixie", ["debian trixie", "debian trixie-updates", "debian-security trixie-security"]),
    ("unstable", ["debian unstable"]),
])  # fmt: skip
def test_the_suite_comes_from_the_mirrors_of_this_machine(machine, suite, parts):
    machine.command("apt-get", APT_GET)
    machine.variables["BILAYER_SUITE"] = suite
    machine.finish()
    lines = [line for line in machine.mmdebstrap_arguments if line.startswith("deb ")]
    found = sorted(line.partition("http://mirror/")[2] for line in lines)
    assert found == sorted(f"{part} main" for part in parts)


def test_progress_is_shown_in_milestones(machine):
    script = FAKE_MMDEBSTRAP + (
        'echo "I: running apt-get update..."\n'
        'echo "0 upgraded, 250 newly installed, 0 to remove and 0 not upgraded."\n'
        'for i in $(seq 250); do echo "Unpacking p$i (1.0) ..."; done\n'
    )
    machine.command("mmdebstrap", script)
    errors = machine.finish()[2]
    assert "reading the package index" in errors
    assert [line.split(" (")[0] for line in errors.splitlines() if "unpacking" in line] == [
        f"scripts/env: unpacking packages: {count} of 250" for count in (1, 101, 201)
    ]


@pytest.mark.parametrize(
    ("missing", "package"), [("mmdebstrap", "mmdebstrap"), ("bwrap", "bubblewrap")]
)
def test_what_is_missing_is_installed_as_root_and_nothing_else(machine, missing, package):
    script = (machine.folder / "commands" / missing).read_text()
    hide_system_commands(machine, missing)
    machine.command(
        "apt-get",
        '#!/bin/bash\n[[ $1 == install ]] || exit 0\necho "$@" >>"$FAKE/apt"\n'
        f'mv "$FAKE/{missing}" "$FAKE/commands/{missing}"\n',
    )
    (machine.folder / missing).write_text(script)
    (machine.folder / missing).chmod(0o755)
    status, _, errors = machine.finish()
    if os.getuid() == 0:
        assert status == 0
        (installed,) = (machine.folder / "apt").read_text().splitlines()
        assert [word for word in installed.split()[1:] if word[0] != "-"] == [package]
    else:
        assert status == 1
        assert is_one_line(errors)
        assert f"apt-get install {package}" in errors


def test_where_no_way_is_open_one_line_says_what_to_install(machine):
    hide_system_commands(machine, "mmdebstrap")
    status, output, errors = machine.finish()
    assert (status, output) == (1, "")
    assert is_one_line(errors)
    assert "apt-get install mmdebstrap" in errors


@pytest.mark.parametrize("refused", ["bwrap", "unshare"])
def test_where_namespaces_are_not_allowed_one_line_says_so(machine, refused):
    machine.command("id", "#!/bin/sh\necho mara\n")
    machine.command(refused, f"#!/bin/sh\necho '{refused}: Operation not permitted' >&2; exit 1\n")
    if refused == "unshare" and os.getuid() == 0:
        pytest.skip("root needs no user namespace")
    status, output, errors = machine.finish()
    assert (status, output) == (1, "")
    assert is_one_line(errors)
    assert "user namespaces" in errors or "subuids" in errors


def test_what_bubblewrap_says_is_shown_with_apparmors_part_in_it(machine):
    machine.command("id", "#!/bin/sh\necho mara\n")
    machine.command("bwrap", "#!/bin/sh\necho 'bwrap: uid map: Permission denied' >&2; exit 1\n")
    status, output, errors = machine.finish()
    assert (status, output) == (1, "")
    assert is_one_line(errors)
    assert "bwrap: uid map: Permission denied" in errors
    assert "kernel.apparmor_restrict_unprivileged_userns" in errors


def test_a_root_that_bubblewrap_is_kept_from_later_is_told_the_same(machine):
    machine.finish()
    machine.command("bwrap", "#!/bin/sh\necho 'bwrap: no right to it' >&2; exit 1\n")
    errors = machine.finish()[2]
    assert is_one_line(errors)
    assert "bwrap: no right to it" in errors
    assert "AppArmor" in errors


def test_a_cache_that_cannot_be_made_is_one_line_with_the_variable_to_set(machine):
    machine.variables["XDG_CACHE_HOME"] = "/proc"
    status, output, errors = machine.finish()
    assert (status, output) == (1, "")
    assert is_one_line(errors)
    assert "/proc/bilayer-shells" in errors
    assert "set XDG_CACHE_HOME" in errors


# ---------------------------------------------------------------- the user's variables and folders


def run_with(variables: dict[str, str], *command: str | Path) -> subprocess.CompletedProcess[str]:
    """Run with these variables and the path of commands, no others."""
    folders = os.environ["PATH"].split(":")
    path = ":".join(folder for folder in folders if not folder.startswith(str(CHECKOUT)))
    own = {"PATH": path, "BILAYER_ENV": "native"} | variables
    return subprocess.run(command, env=own, capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("home", [{}, {"HOME": ""}], ids=["unset", "empty"])
def test_without_home_the_folder_of_the_password_file_is_taken(home):
    result = run_with(home, ENV, "bash", "-c", "echo $HOME")
    assert result.stdout == f"{pwd.getpwuid(os.getuid()).pw_dir}\n"
    assert result.stderr == ""


def test_a_cache_folder_that_is_relative_is_not_taken(tmp_path):
    cache = {"HOME": str(tmp_path), "XDG_CACHE_HOME": "cache", "BILAYER_ENV": "root"}
    assert f"root: {tmp_path}/.cache/bilayer-shells/root-" in run_with(cache, ENV, "--where").stdout


def test_a_temporary_folder_that_is_gone_is_not_handed_on(tmp_path):
    gone = run_with({"TMPDIR": str(tmp_path / "gone")}, ENV, "bash", "-c", "echo ${TMPDIR-none}")
    there = run_with({"TMPDIR": str(tmp_path)}, ENV, "bash", "-c", "echo ${TMPDIR-none}")
    assert gone.stdout == "none\n"
    assert is_one_line(gone.stderr)
    assert f"TMPDIR = {tmp_path}/gone" in gone.stderr
    assert (there.stdout, there.stderr) == (f"{tmp_path}\n", "")


@pytest.mark.parametrize("name", ["run 3: soft", "it's", 'a "b" $HOME', "-n; true"])
def test_a_checkout_may_have_any_name(tmp_path, name):
    checkout = tmp_path / name
    for folder in ("scripts", "docker"):
        shutil.copytree(CHECKOUT / folder, checkout / folder)
    (checkout / "shape.py").write_text("print('found')")
    cache = {"XDG_CACHE_HOME": str(tmp_path / "cache"), "HOME": str(tmp_path)}
    result = run_with(cache, checkout / "scripts" / "env", "python3", "-P", "-m", "shape")
    assert (result.stdout, result.stderr) == ("found\n", "")
    result = run_with(cache, checkout / "scripts" / "env", "bash", "-c", "type -P bilayer")
    assert Path(result.stdout.rstrip("\n")).resolve() == checkout / "scripts" / "bilayer"


def test_a_current_folder_that_is_gone_is_named(root_of_this_system, tmp_path):
    folder = tmp_path / "job"
    folder.mkdir()
    call = f'cd "{folder}" && rmdir "{folder}" && exec "{ENV}" true'
    result = run_with({"BILAYER_ENV": str(root_of_this_system)}, "bash", "-c", call)
    assert result.returncode == 2
    assert f"the current folder {folder} is gone" in result.stderr


# ---------------------------------------------------------------- CalculiX


def test_the_ccx_of_this_machine_is_taken_and_the_script_never_finds_itself(machine):
    machine.command("ccx", '#!/bin/sh\necho "$OMP_NUM_THREADS in $PWD:" "$@"; exit 3\n')
    scripts = machine.checkout / "scripts"
    machine.variables |= {"PATH": f"{scripts}:{machine.variables['PATH']}", "OMP_NUM_THREADS": ""}
    status, output, errors = machine.finish("-i", "a deck", script="ccx")
    assert (status, errors) == (3, "")
    assert output == f"1 in {Path.cwd()}: -i a deck\n"


def test_without_one_a_small_root_of_debian_12_is_made_once(machine):
    machine.finish()
    (main_root,) = machine.all_roots
    hide_system_commands(machine, "ccx")
    assert "not built yet" in machine.finish("--where", script="ccx")[1]
    status, output, errors = machine.finish("-v", script="ccx")
    assert (status, output) == (0, "entered\n")
    assert "scripts/ccx: making a Debian bookworm environment" in errors
    arguments = machine.mmdebstrap_arguments
    assert "--include=calculix-ccx" in arguments
    assert "bookworm" in arguments
    assert machine.finish("-v", script="ccx") == (0, "entered\n", "")
    assert machine.builds == 2
    assert main_root in machine.all_roots


def test_inside_the_environment_one_line_says_that_it_is_made_outside(machine):
    hide_system_commands(machine, "mmdebstrap")
    machine.variables["BILAYER_ENV"] = "native"
    status, output, errors = machine.finish("-v", script="ccx")
    assert (status, output) == (1, "")
    assert is_one_line(errors)
    assert "start scripts/ccx once outside" in errors


def hide_system_commands(machine: Machine, missing: str) -> None:
    """Leave on the PATH what a plain system has, without apt-get and the missing command."""
    (machine.folder / "commands" / missing).unlink(missing_ok=True)
    for command in Path("/usr/bin").iterdir():
        link = machine.folder / "commands" / command.name
        if command.name not in (missing, "apt-get", "ccx") and not link.exists():
            link.symlink_to(command)
    machine.variables["PATH"] = str(machine.folder / "commands")
