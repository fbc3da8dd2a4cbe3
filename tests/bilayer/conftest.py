"""A disk that is full, for the tests of everything that writes; `verification` importable."""

import contextlib
import resource
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))


@pytest.fixture
def full_disk():
    """Within it no file can grow beyond a few bytes: the system refuses, as on a full disk."""

    @contextlib.contextmanager
    def refuse(size=512):
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

    return refuse
