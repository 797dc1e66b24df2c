"""Where compiled programs are kept, and what is not trusted."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from jaxatt.runtime.compile_cache import clear, kept, make_private, trim

SOLVE = ("solve", "double-integrator", "--starts", "2", "--quiet", "--figures", "none")


def run(home, *arguments, **variables):
    environment = {k: v for k, v in os.environ.items() if k != "JAX_COMPILATION_CACHE_DIR"}
    return subprocess.run(
        [sys.executable, "-m", "jaxatt", *arguments],
        env={**environment, "XDG_CACHE_HOME": str(home / "cache"), **variables},
        cwd=home,
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A home folder after a first solve."""
    home = tmp_path_factory.mktemp("home")
    done = run(home, *SOLVE, "--out", "first")
    assert done.returncode == 0, done.stderr
    return home


def files(home):
    return sorted(path for path in (home / "cache").rglob("*") if path.is_file())


def answer(home, out):
    return json.loads((home / out / "summary.json").read_text())["cost"]


@pytest.mark.skipif(sys.platform != "linux", reason="folders of Linux")
def test_programs_are_kept_in_a_folder_of_ones_own(home):
    assert len(files(home)) > 3
    (folder,) = (home / "cache/jaxatt/compiled").iterdir()
    assert folder.stat().st_mode & 0o777 == 0o700
    before = {path: path.stat().st_mtime_ns for path in files(home)}
    assert run(home, *SOLVE, "--out", "again").returncode == 0
    assert {path: path.stat().st_mtime_ns for path in files(home)} == before, "nothing compiled"
    assert answer(home, "again") == answer(home, "first")
    told = run(home, "cache", "info").stdout
    assert f"{len(before)} files" in told and "1024 MiB" in told


@pytest.mark.skipif(sys.platform != "linux", reason="folders of Linux")
def test_damaged_files_are_named_and_compiled_again(home):
    rng = np.random.default_rng(7)
    for path in files(home):
        path.write_bytes(rng.bytes(100))
    done = run(home, *SOLVE, "--out", "damaged")
    assert done.returncode == 0, done.stderr
    assert answer(home, "damaged") == answer(home, "first")
    assert "is removed" in done.stderr
    assert all(line.startswith("Warning: ") for line in done.stderr.splitlines()), done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="folders of Linux")
def test_programs_that_only_the_cache_of_jax_has_are_run(home):
    (folder,) = (home / "cache/jaxatt/compiled").iterdir()
    for path in (folder / "jaxatt").iterdir():
        path.unlink()
    for out in ("third", "fourth"):
        done = run(home, *SOLVE, "--out", out)
        assert done.returncode == 0, done.stderr
        assert answer(home, out) == answer(home, "first")


@pytest.mark.skipif(sys.platform != "linux", reason="folders of Linux")
def test_a_folder_that_others_may_write_into_is_not_used(tmp_path):
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    done = run(tmp_path, *SOLVE, "--out", "out", JAX_COMPILATION_CACHE_DIR=str(shared))
    assert done.returncode == 0, done.stderr
    assert "others may write into it" in done.stderr and "chmod 700" in done.stderr
    assert not any(shared.iterdir())


@pytest.mark.skipif(sys.platform != "linux", reason="folders of Linux")
def test_nothing_is_kept_unless_wanted(tmp_path):
    done = run(tmp_path, *SOLVE, "--out", "out", "--no-cache")
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "cache").exists()


def test_what_was_used_longest_ago_goes_first(tmp_path):
    rng = np.random.default_rng(3)
    times, sizes = rng.permutation(20), rng.integers(1, 1000, 20)
    for number, (time, size) in enumerate(zip(times, sizes, strict=True)):
        path = tmp_path / f"folder{number % 3}" / str(number)
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(bytes(int(size)))
        os.utime(path, (1e9 + float(time), 1e9))
    assert kept(tmp_path) == (20, sizes.sum())
    most = int(sizes.sum() // 2)
    trim(tmp_path, most)
    left = sorted(int(times[int(p.name)]) for p in tmp_path.rglob("*") if p.is_file())
    assert left == list(range(20 - len(left), 20))
    held = kept(tmp_path)
    oldest_gone = sizes[list(times).index(20 - len(left) - 1)]
    assert held.size <= most < held.size + oldest_gone
    assert clear(tmp_path) == held and not tmp_path.exists()


def test_a_file_in_its_place_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    assert "cannot be used" in make_private(tmp_path / "file" / "below")
