"""Files that appear whole: what is an error of writing, and what is not."""

import errno

import pytest

from bilayer.errors import InputError, NotWrittenError
from bilayer.runtime.output_file import remove_leftovers, whole_file


@pytest.mark.parametrize(
    "error",
    [
        RuntimeError("a fault"),
        ValueError("a fault"),
        InputError("a bad value"),
        FileNotFoundError(errno.ENOENT, "no such file", "/another/file"),
        ConnectionError("lost"),
    ],
)
def test_an_error_that_is_not_of_writing_passes_as_it_is(tmp_path, error):
    with pytest.raises(type(error)) as raised, whole_file(tmp_path / "a.txt", "text"):
        raise error
    assert raised.value is error
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EDQUOT])
def test_an_error_of_the_disk_is_one_of_writing(tmp_path, number):
    with (
        pytest.raises(NotWrittenError, match=r"^text .*a\.txt: cannot be written \("),
        whole_file(tmp_path / "a.txt", "text"),
    ):
        raise OSError(number, "the disk")


def test_an_error_of_the_file_itself_is_one_of_writing(tmp_path):
    with (
        pytest.raises(NotWrittenError, match="cannot be written"),
        whole_file(tmp_path / "a.txt", "text") as partial,
    ):
        (partial / "below a file that is not there").write_text("x")


def test_leftovers_of_a_killed_process_go_and_nothing_else(tmp_path):
    left, others = tmp_path / ".run.abcdefgh", tmp_path / ".run.archived"
    for folder, name in ((left, "run.nc"), (others, "mine.txt")):
        folder.mkdir()
        (folder / name).write_text("x")
    (tmp_path / ".run.12345678").write_text("a file")
    (tmp_path / "run.nc").write_text("whole")
    remove_leftovers(tmp_path / "run.nc")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        ".run.12345678", ".run.archived", "run.nc",
    ]  # fmt: skip
